/* A plugin that has the static library in itself. */
#include <lamella/lamella.h>

uint64_t plugin_hash(const lamella_mesh* mesh, const lamella_options* options);

/* Of the mesh sliced; 0 where that fails. */
uint64_t plugin_hash(const lamella_mesh* mesh, const lamella_options* options) {
    lamella_result* result = NULL;
    uint64_t hash = 0;
    if (lamella_slice(NULL, mesh, options, &result, NULL) == LAMELLA_OK) {
        hash = lamella_result_hash(result);
        lamella_result_free(result);
    }
    return hash;
}
