/* Measures of sections, from C: areas, lengths, centroids, second moments, boxes and diameters.
 *
 *     const lamella_point foot[] = {{0, 0}, {4, 0}, {4, 2}, {0, 2}};
 *     const lamella_path rectangle = {foot, 4};
 *     lamella_result* result = NULL;
 *     lamella_section_measures layer;
 *     if (lamella_region_of(&rectangle, 1, NULL, 1, NULL, &result, NULL) == LAMELLA_OK &&
 *         lamella_measure(result, 1, NULL, &layer, 1, NULL, 0, NULL) == LAMELLA_OK) {
 *         printf("%g mm2, Imax %g mm4\n", layer.area_mm2, layer.imax_mm4);
 *     }
 *     lamella_result_free(result);
 *
 * lamella/measures.hpp says what each number is; lamella.h how handles and errors are used. */
#ifndef LAMELLA_MEASURES_H
#define LAMELLA_MEASURES_H

#include "lamella/lamella.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lamella_section_measures {
    uint64_t layer;
    int64_t contour; /* an island's outer; of a layer -1 */
    double z_mm;
    int32_t islands, holes, open;
    uint8_t known, reserved[3];
    double area_mm2, outer_area_mm2, perimeter_mm, outer_perimeter_mm, centroid_mm[2];
    double ix_mm4, iy_mm4, ixy_mm4, imin_mm4, imax_mm4, angle_rad, polar_mm4;
    double box_min_mm[2], box_max_mm[2];
    double feret_max_mm, feret_min_mm, feret_angle_rad; /* NaN where `feret` is 0 */
    double equivalent_diameter_mm, circularity;
} lamella_section_measures;

/* Fills the program's arrays: a row a layer, and where `islands` is not NULL one for each contour of role LAMELLA_OUTER. The
 * counts must be those. */
LAMELLA_C_API int32_t lamella_measure(const lamella_result* result, int32_t feret, const lamella_context* context,
                                      lamella_section_measures* layers, size_t layer_count,
                                      lamella_section_measures* islands, size_t island_count, lamella_error* error);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* LAMELLA_MEASURES_H */
