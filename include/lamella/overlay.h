/* Layers combined with layers, from C: unions, differences and intersections of whole stacks, and regions by label.
 *
 *     const lamella_point low[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
 *     const lamella_point high[] = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
 *     const lamella_path squares[] = {{low, 4}, {high, 4}};
 *     lamella_layer_set sets[2];
 *     lamella_rule subtract;
 *     lamella_result* result = NULL;
 *     lamella_destination to;
 *     for (int i = 0; i < 2; ++i) {
 *         LAMELLA_INIT(&sets[i], LAMELLA_LAYER_SET);
 *         sets[i].contours = &squares[i];
 *         sets[i].contour_count = 1;
 *         sets[i].contour_grid_mm = 1;
 *     }
 *     LAMELLA_INIT(&subtract, LAMELLA_RULE);
 *     subtract.any = 1;
 *     subtract.none = 2;
 *     LAMELLA_INIT(&to, LAMELLA_DESTINATION);
 *     to.result = &result;
 *     if (lamella_overlay_combine(NULL, &to, sets, 2, &subtract, NULL, NULL, NULL, NULL) == LAMELLA_OK) {
 *         lamella_layer_view layer;
 *         LAMELLA_INIT(&layer, LAMELLA_LAYER_VIEW);
 *         lamella_result_layer(result, 0, &layer);
 *         printf("%g mm2\n", lamella_area_mm2(&layer));
 *     }
 *     lamella_result_free(result);
 *
 * lamella/overlay.hpp says what sets and rules are, what the call does and what fails; lamella.h how structs, handles,
 * callbacks and errors are used. */
#ifndef LAMELLA_OVERLAY_H
#define LAMELLA_OVERLAY_H

#include "lamella/lamella.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LAMELLA_MOST_LAYER_SETS 63
#define LAMELLA_MOST_LABELS 65535

/* For layer n of the answer the union of its layers n + from to n + to. Of result and contours at most one is set; neither:
 * no solid at all. */
typedef struct lamella_layer_set {
    uint32_t struct_size;
    int32_t fill_rule;            /* of contours that bound no region yet; LAMELLA_FILL_RULE_NON_ZERO by default */
    const lamella_result* result; /* a stack */
    int64_t layer;                /* of it this one only, which stands at every height; -1, the default: all */
    const lamella_path* contours; /* these stand at every height */
    size_t contour_count;
    double contour_grid_mm; /* a grid unit of theirs; LAMELLA_DEFAULT_GRID_MM by default */
    int32_t from, to;
    double grow_mm;
    int64_t part; /* of contours of this part only; -1, the default: of all */
} lamella_layer_set;

/* From membership (bit i: inside set i) to a label. 0: empty; label l becomes part l - 1. By default the union. */
typedef struct lamella_rule {
    uint32_t struct_size;
    int32_t reserved;
    uint64_t any, all, none, not_all; /* label 1 inside one of any, each of all, none of none, outside one of not_all, */
    int32_t odd;                      /* and inside an odd number of sets; */
    int32_t last_wins;                /* there instead 1 + the number of the last set of any */
    const uint32_t* labels;           /* instead of all that 2^sets labels, by membership; */
    size_t label_count;
    uint32_t (*label_of)(void* object, uint64_t inside); /* or a function, on any working thread, several at once */
    void* label_object;
} lamella_rule;

/* One step of an offset: how far edges move, outwards where it is above 0, from where the step before left them. */
typedef struct lamella_offset_step {
    double mm;
    int32_t drop; /* not 0: its region is no part of the answer */
    int32_t reserved;
} lamella_offset_step;

enum { LAMELLA_JOIN_MITER = 0, LAMELLA_JOIN_ROUND = 1, LAMELLA_JOIN_SQUARE = 2 };
enum { LAMELLA_END_REGION = 0, LAMELLA_END_BUTT = 1, LAMELLA_END_SQUARE = 2, LAMELLA_END_ROUND = 3 };

typedef struct lamella_offset {
    uint32_t struct_size;
    int32_t join;
    int32_t end;
    int32_t reserved;
    double miter_limit;      /* 3 by default */
    double arc_tolerance_mm; /* 0.005 by default */
} lamella_offset;

typedef struct lamella_overlay lamella_overlay;

/* Scratch that is kept from call to call, one for each thread that calls. NULL where there is no memory. */
LAMELLA_C_API lamella_overlay* lamella_overlay_create(void);
LAMELLA_C_API void lamella_overlay_reset(lamella_overlay* overlay);
LAMELLA_C_API void lamella_overlay_free(lamella_overlay* overlay);

/* `sets` is an array whose elements begin with one size. Overlay, rule, `after`, context, info and error may be NULL. Of
 * `after` the rules of regions are used, but for the fill rule. The answer cannot take the place of a set's result. */
LAMELLA_C_API int32_t lamella_overlay_combine(lamella_overlay* overlay, const lamella_destination* to,
                                              const lamella_layer_set* sets, size_t set_count, const lamella_rule* rule,
                                              const lamella_options* after, const lamella_context* context,
                                              lamella_info* info, lamella_error* error);

/* Kept steps are parts 0, 1, ... of the answer. Overlay, offset, `after`, context, info and error may be NULL. */
LAMELLA_C_API int32_t lamella_overlay_offset(lamella_overlay* overlay, const lamella_destination* to,
                                             const lamella_layer_set* of, const lamella_offset_step* steps,
                                             size_t step_count, const lamella_offset* offset, const lamella_options* after,
                                             const lamella_context* context, lamella_info* info, lamella_error* error);

/* What lamella_overlay_clip() keeps; 0: what lies inside, and what runs along a boundary. */
enum {
    LAMELLA_CLIP_OUTSIDE = 1,            /* what lies outside instead */
    LAMELLA_CLIP_BOUNDARY_IS_OUTSIDE = 2 /* what runs along a boundary counts as outside */
};

/* The pieces of polylines, as open contours in order along each; part is the polyline's number. Of `lines`, which are a
 * result, one of its layers, or open contours of the program's, only these are set. `keep`: flags, together. Overlay,
 * context, info and error may be NULL. */
LAMELLA_C_API int32_t lamella_overlay_clip(lamella_overlay* overlay, const lamella_destination* to,
                                           const lamella_layer_set* lines, const lamella_layer_set* by, int32_t keep,
                                           const lamella_context* context, lamella_info* info, lamella_error* error);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* LAMELLA_OVERLAY_H */
