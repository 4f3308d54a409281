/* A host that has the library in itself, loads two copies of the shared one, and a plugin that has one in itself: all four
 * cut the same mesh, each by its own functions. The host exports its symbols, as hosts of plugins do.
 *
 *     plugins COPY COPY PLUGIN SAMPLE */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sample.h"

/* Where the function of that name lies in a loaded library. */
static void find(void* library, const char* name, void* function, size_t size) {
    void* const found = dlsym(library, name);
    if (found == NULL || size != sizeof found) {
        fprintf(stderr, "no %s: %s\n", name, dlerror());
        exit(1);
    }
    memcpy(function, &found, size);
}

static uint64_t hash_by(void* library, const lamella_mesh* mesh, const lamella_options* options) {
    int32_t (*slice)(lamella_slicer*, const lamella_mesh*, const lamella_options*, lamella_result**, lamella_error*);
    int32_t (*prepare)(const lamella_mesh*, const lamella_options*, const lamella_context*, lamella_prepared**, lamella_error*);
    uint64_t (*hash_of)(const lamella_result*);
    void (*free_result)(lamella_result*);
    void (*free_prepared)(lamella_prepared*);
    lamella_result* result = NULL;
    lamella_prepared* prepared = NULL;
    uint64_t hash = 0;
    find(library, "lamella_slice", &slice, sizeof slice);
    find(library, "lamella_prepare", &prepare, sizeof prepare);
    find(library, "lamella_result_hash", &hash_of, sizeof hash_of);
    find(library, "lamella_result_free", &free_result, sizeof free_result);
    find(library, "lamella_prepared_free", &free_prepared, sizeof free_prepared);
    if (slice == lamella_slice) {
        fprintf(stderr, "the library's functions are those of the host\n");
        exit(1);
    }
    /* The second call frees what the first one made. */
    if (slice(NULL, mesh, options, &result, NULL) != LAMELLA_OK ||
        prepare(mesh, options, NULL, &prepared, NULL) != LAMELLA_OK ||
        prepare(mesh, options, NULL, &prepared, NULL) != LAMELLA_OK) {
        fprintf(stderr, "a loaded library cuts nothing\n");
        exit(1);
    }
    hash = hash_of(result);
    free_result(result);
    free_prepared(prepared);
    return hash;
}

static void* load(const char* path) {
    void* const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return library;
}

int main(int count, char** words) {
    void* copies[2];
    void* plugin = NULL;
    uint64_t (*plugin_hash)(const lamella_mesh*, const lamella_options*);
    lamella_result* result = NULL;
    lamella_mesh mesh;
    lamella_options options;
    uint64_t hash = 0;
    unsigned char* const bytes = count == 5 ? read_sample(words[4], &mesh) : NULL;
    if (bytes == NULL) {
        return 1;
    }
    LAMELLA_INIT(&options, LAMELLA_OPTIONS);
    options.layer_height_mm = 0.5;
    if (lamella_slice(NULL, &mesh, &options, &result, NULL) != LAMELLA_OK) {
        return 1;
    }
    hash = lamella_result_hash(result);
    copies[0] = load(words[1]);
    copies[1] = load(words[2]);
    plugin = load(words[3]);
    find(plugin, "plugin_hash", &plugin_hash, sizeof plugin_hash);
    if (copies[0] == copies[1] || dlsym(plugin, "lamella_slice") != NULL) {
        fprintf(stderr, "one library was loaded, not two, or the plugin shows what it has in itself\n");
        return 1;
    }
    if (hash_by(copies[0], &mesh, &options) != hash || hash_by(copies[1], &mesh, &options) != hash ||
        plugin_hash(&mesh, &options) != hash) {
        fprintf(stderr, "not all cut the same\n");
        return 1;
    }
    dlclose(copies[0]);
    dlclose(copies[1]);
    dlclose(plugin);
    print_counts(result);
    lamella_result_free(result);
    free(bytes);
    return 0;
}
