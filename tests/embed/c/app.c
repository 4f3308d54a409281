/* Cuts a binary STL file by way of the C interface. Compiled as C99 and as C++17, and linked with the shared library and
 * with the static one. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lamella/lamella.h>

static unsigned char* read_all(const char* path, size_t* size) {
    FILE* file = fopen(path, "rb");
    unsigned char* bytes = NULL;
    if (file == NULL) {
        return NULL;
    }
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    bytes = (unsigned char*)malloc(*size);
    if (fread(bytes, 1, *size, file) != *size) {
        free(bytes);
        bytes = NULL;
    }
    fclose(file);
    return bytes;
}

static void count_layer(void* context, const lamella_layer_view* layer) {
    *(uint64_t*)context += layer->contour_count;
}

int main(int count, char** words) {
    size_t size = 0;
    unsigned char* bytes = read_all(words[count - 1], &size);
    uint32_t triangles = 0;
    uint64_t handed_over = 0;
    lamella_mesh mesh;
    lamella_options options;
    lamella_error error;
    lamella_view view;
    lamella_sink sink = {count_layer, NULL, LAMELLA_SINK_ASCENDING, 0};
    lamella_result* result = NULL;
    if (bytes == NULL || size < 84) {
        fprintf(stderr, "no mesh\n");
        return 1;
    }
    memcpy(&triangles, bytes + 80, sizeof triangles);
    lamella_mesh_init(&mesh);
    mesh.vertices = bytes + 84 + 12;
    mesh.vertex_stride = 50;
    mesh.triangle_count = triangles;
    lamella_options_init(&options);
    options.layer_height_mm = 0.5;
    lamella_error_init(&error);
    if (lamella_slice(&mesh, &options, NULL, &result, &error) != LAMELLA_OK) {
        fprintf(stderr, "%s: %s\n", lamella_status_name(error.status), error.message);
        return 1;
    }
    sink.context = &handed_over;
    if (lamella_slice_to(&sink, &mesh, &options, NULL, NULL, &error) != LAMELLA_OK) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    lamella_view_init(&view);
    lamella_result_view(result, &view);
    if (handed_over != view.contour_count) {
        fprintf(stderr, "the sink got %d contours\n", (int)handed_over);
        return 1;
    }
    printf("%d layers, %d contours\n", (int)view.layer_count, (int)view.contour_count);
    lamella_result_free(result);
    free(bytes);
    return 0;
}
