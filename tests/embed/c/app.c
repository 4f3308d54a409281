/* Cuts a binary STL file by way of the C interface. Compiled as C99 and as C++17, and linked with the shared library and
 * with the static one. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lamella/lamella.h>

/* The file's bytes, which `mesh` looks at; to be freed. NULL where there is no mesh. */
static unsigned char* read_sample(const char* path, lamella_mesh* mesh) {
    FILE* file = fopen(path, "rb");
    unsigned char* bytes = NULL;
    uint32_t triangles = 0;
    size_t size = 0;
    if (file == NULL) {
        return NULL;
    }
    fseek(file, 0, SEEK_END);
    size = (size_t)ftell(file);
    rewind(file);
    bytes = (unsigned char*)malloc(size);
    if (size < 84 || fread(bytes, 1, size, file) != size) {
        fprintf(stderr, "%s is no mesh\n", path);
        free(bytes);
        bytes = NULL;
    } else {
        memcpy(&triangles, bytes + 80, sizeof triangles);
        LAMELLA_INIT(mesh, LAMELLA_MESH);
        mesh->vertices = bytes + 84 + 12;
        mesh->vertex_stride = 50;
        mesh->triangle_count = triangles;
    }
    fclose(file);
    return bytes;
}

static void count_layer(void* object, const lamella_layer_view* layer) {
    *(uint64_t*)object += layer->layer.contour_count;
}

int main(int count, char** words) {
    uint64_t handed_over = 0;
    lamella_mesh mesh;
    lamella_options options;
    lamella_source from;
    lamella_destination to;
    lamella_sink sink;
    lamella_error error;
    lamella_view view;
    lamella_result* result = NULL;
    unsigned char* const bytes = read_sample(words[count - 1], &mesh);
    if (bytes == NULL) {
        return 1;
    }
    LAMELLA_INIT(&options, LAMELLA_OPTIONS);
    options.layer_height_mm = 0.5;
    LAMELLA_INIT(&error, LAMELLA_ERROR);
    if (lamella_slice(NULL, &mesh, &options, &result, &error) != LAMELLA_OK) {
        fprintf(stderr, "%s: %s\n", lamella_status_name(error.status), error.message);
        return 1;
    }
    LAMELLA_INIT(&from, LAMELLA_SOURCE);
    from.mesh = &mesh;
    LAMELLA_INIT(&sink, LAMELLA_SINK);
    sink.take = count_layer;
    sink.object = &handed_over;
    LAMELLA_INIT(&to, LAMELLA_DESTINATION);
    to.sink = &sink;
    if (lamella_slice_to(NULL, &to, &from, &options, NULL, NULL, &error) != LAMELLA_OK) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    LAMELLA_INIT(&view, LAMELLA_VIEW);
    lamella_result_view(result, &view);
    if (handed_over != view.info.contours) {
        fprintf(stderr, "the sink got %d contours\n", (int)handed_over);
        return 1;
    }
    printf("hash %08x%08x\n", (unsigned)(lamella_result_hash(result) >> 32), (unsigned)lamella_result_hash(result));
    printf("%d layers, %d contours\n", (int)view.info.layers, (int)view.info.contours);
    lamella_result_free(result);
    free(bytes);
    return 0;
}
