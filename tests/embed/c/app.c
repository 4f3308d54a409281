/* Cuts a binary STL file by way of the C interface. Compiled as C99 and as C++17, and linked with the shared library and
 * with the static one. */
#include "sample.h"

static void count_layer(void* context, const lamella_layer_view* layer) {
    *(uint64_t*)context += layer->contour_count;
}

int main(int count, char** words) {
    uint64_t handed_over = 0;
    lamella_mesh mesh;
    lamella_options options;
    lamella_error error;
    lamella_view view;
    lamella_sink sink = {count_layer, NULL, LAMELLA_SINK_ASCENDING, 0};
    lamella_result* result = NULL;
    unsigned char* const bytes = read_sample(words[count - 1], &mesh);
    if (bytes == NULL) {
        return 1;
    }
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
    print_counts(result);
    lamella_result_free(result);
    free(bytes);
    return 0;
}
