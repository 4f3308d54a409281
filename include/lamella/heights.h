/* Layers as high as the surface allows, from C.
 *
 *     const float soup[] = {0, 0, 0, 0, 9, 0, 9, 0, 0,  0, 0, 0, 9, 0, 0, 0, 0, 9,
 *                           0, 0, 0, 0, 0, 9, 0, 9, 0,  9, 0, 0, 0, 9, 0, 0, 0, 9};
 *     lamella_mesh mesh;
 *     lamella_source source;
 *     lamella_adaptive adaptive;
 *     lamella_slabs* slabs = NULL;
 *     LAMELLA_INIT(&mesh, LAMELLA_MESH);
 *     mesh.vertices = soup;
 *     mesh.triangle_count = 4;
 *     LAMELLA_INIT(&source, LAMELLA_SOURCE);
 *     source.mesh = &mesh;
 *     LAMELLA_INIT(&adaptive, LAMELLA_ADAPTIVE);
 *     adaptive.cusp_mm = 0.04;
 *     if (lamella_adaptive_layers(&source, &adaptive, NULL, NULL, &slabs, NULL) == LAMELLA_OK) {
 *         lamella_options options;
 *         LAMELLA_INIT(&options, LAMELLA_OPTIONS);
 *         options.slabs = lamella_slabs_view(slabs, &options.slab_count);
 *         printf("%lu layers\n", (unsigned long)options.slab_count);
 *     }
 *     lamella_slabs_free(slabs);
 *
 * lamella/heights.hpp says what each field does and what fails; lamella.h how structs, handles and errors are used. */
#ifndef LAMELLA_HEIGHTS_H
#define LAMELLA_HEIGHTS_H

#include "lamella/lamella.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lamella_height_range {
    double from_mm, to_mm, height_mm;
} lamella_height_range;

typedef struct lamella_adaptive {
    uint32_t struct_size;
    int32_t reserved;
    double least_mm, most_mm, step_mm;
    double cusp_mm, deviation_mm, slope_limit_mm; /* each that is not 0 holds */
    double most_change_mm, smoothing_mm;
    const lamella_height_range* ranges;
    size_t range_count;
} lamella_adaptive;

typedef struct lamella_slabs lamella_slabs;

/* Of `options` those of the frame are used. */
LAMELLA_C_API int32_t lamella_adaptive_layers(const lamella_source* from, const lamella_adaptive* adaptive,
                                              const lamella_options* options, const lamella_context* context,
                                              lamella_slabs** slabs, lamella_error* error);
/* For lamella_options.slabs: as long as the handle is there. */
LAMELLA_C_API const lamella_slab* lamella_slabs_view(const lamella_slabs* slabs, size_t* count);
LAMELLA_C_API void lamella_slabs_free(lamella_slabs* slabs);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* LAMELLA_HEIGHTS_H */
