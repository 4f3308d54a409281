/* Islands followed from layer to layer, from C.
 *
 *     const lamella_point foot[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
 *     const lamella_path square = {foot, 4};
 *     lamella_result* result = NULL;
 *     lamella_tracks* tracks = NULL;
 *     lamella_track_options options;
 *     lamella_track_arrays found;
 *     LAMELLA_INIT(&options, LAMELLA_TRACK_OPTIONS);
 *     LAMELLA_INIT(&found, LAMELLA_TRACK_ARRAYS);
 *     options.pockets = 1;
 *     if (lamella_region_of(&square, 1, NULL, 1, NULL, &result, NULL) == LAMELLA_OK &&
 *         lamella_find_tracks(result, &options, NULL, &tracks, NULL) == LAMELLA_OK) {
 *         lamella_tracks_view(tracks, &found);
 *         for (uint64_t i = 0; i < found.island_count; ++i) {
 *             printf("island %lu: %u below\n", (unsigned long)i, (unsigned)found.islands[i].below);
 *         }
 *     }
 *     lamella_tracks_free(tracks);
 *     lamella_result_free(result);
 *
 * lamella/tracks.hpp says what islands, links and pockets are, and what fails; lamella.h how structs, handles and errors are
 * used. */
#ifndef LAMELLA_TRACKS_H
#define LAMELLA_TRACKS_H

#include "lamella/lamella.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LAMELLA_TRACK_OPTIONS = 17, LAMELLA_TRACK_ARRAYS = 18 }; /* for LAMELLA_INIT */

typedef struct lamella_track_options {
    uint32_t struct_size;
    int32_t pockets; /* 0: no */
} lamella_track_options;

typedef struct lamella_track {
    uint64_t layer, contour;
    double area_mm2, centroid_mm[2];
    uint32_t first_above, above, first_below, below;
    uint32_t body, reserved;
} lamella_track;

typedef struct lamella_track_link {
    uint32_t lower, upper;
} lamella_track_link;

typedef struct lamella_pocket {
    uint64_t contour, first_layer, end_layer;
    double volume_mm3;
    uint8_t is_cavity, reserved[7];
} lamella_pocket;

/* As long as the handle is there. */
typedef struct lamella_track_arrays {
    uint32_t struct_size;
    int32_t reserved;
    const lamella_track* islands;
    uint64_t island_count;
    const lamella_track_link* links;
    const uint32_t* links_by_upper;
    uint64_t link_count;
    const lamella_pocket* pockets;
    uint64_t pocket_count;
    uint64_t bodies;
} lamella_track_arrays;

typedef struct lamella_tracks lamella_tracks;

LAMELLA_C_API int32_t lamella_find_tracks(const lamella_result* result, const lamella_track_options* options,
                                          const lamella_context* context, lamella_tracks** tracks, lamella_error* error);
LAMELLA_C_API void lamella_tracks_view(const lamella_tracks* tracks, lamella_track_arrays* arrays);
LAMELLA_C_API void lamella_tracks_free(lamella_tracks* tracks);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* LAMELLA_TRACKS_H */
