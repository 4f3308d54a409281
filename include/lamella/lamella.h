/* lamella from C, and from every language that can call C.
 *
 *     const float soup[] = {0, 0, 0, 0, 9, 0, 9, 0, 0,  0, 0, 0, 9, 0, 0, 0, 0, 9,
 *                           0, 0, 0, 0, 0, 9, 0, 9, 0,  9, 0, 0, 0, 9, 0, 0, 0, 9};
 *     lamella_mesh mesh;
 *     lamella_mesh_init(&mesh);
 *     mesh.vertices = soup;
 *     mesh.triangle_count = 4;
 *     lamella_options options;
 *     lamella_options_init(&options);
 *     options.layer_height_mm = 0.5;
 *     lamella_result* result = NULL;
 *     lamella_error error;
 *     lamella_error_init(&error);
 *     if (lamella_slice(&mesh, &options, NULL, &result, &error) != LAMELLA_OK) {
 *         fprintf(stderr, "%s\n", error.message);
 *         return;
 *     }
 *     lamella_view view;
 *     lamella_view_init(&view);
 *     lamella_result_view(result, &view);
 *     for (uint64_t i = 0; i < view.layer_count; ++i) {
 *         printf("z %g mm: %g mm2\n", view.layers[i].plane_mm, lamella_result_area_mm2(result, i));
 *     }
 *     lamella_result_free(result);
 *
 * The calls are those of the C++ headers, whose comments say what they do; here stands what C adds. In C++ alone are
 * SliceOptions::layers with first_layer and all_layers of results, experiments.hpp, what lamella/mesh and lamella/audit
 * declare (inspect(), check(), weld(), validate()), and files.
 *
 * Structs that grow from version to version begin with their size and are initialised by a call of that name. A library that
 * is newer than the program gives fields that the program does not know their defaults. One that is older refuses the struct
 * with LAMELLA_INVALID_ARGUMENT where a field is set that it does not know, and takes it where such fields are 0, as the
 * initialisation leaves them. Fields named `reserved` are 0, too. The structs without a size (points, contours, layers, the
 * sink) never change. Enumerations are kept in int32_t.
 *
 * What a call returns is a status, LAMELLA_OK or what went wrong; `error`, which may be NULL, then says more. A handle that
 * was made is given back by its _free(), which takes NULL too. Views point into their handle and live as long, or until it
 * is filled anew. No call throws, prints, aborts or keeps global state. Callbacks must not throw or jump out:
 * one that fails notes it, so that `stop` ends the call, and the program looks at the note when the call is over, whatever
 * its status (tools/docs/embedding.md shows it in Python).
 *
 * A handle may be used by one thread at a time, but for a prepared mesh: that any number of threads may slice at once, each
 * with a workspace and a result of its own. */
#ifndef LAMELLA_LAMELLA_H
#define LAMELLA_LAMELLA_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define LAMELLA_C_API __attribute__((visibility("default")))
#else
#define LAMELLA_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* --- Status and errors */

enum { /* see lamella/error.hpp */
    LAMELLA_OK = 0,
    LAMELLA_INVALID_ARGUMENT = 1,
    LAMELLA_UNREADABLE_FILE = 2,
    LAMELLA_MALFORMED_MESH = 3,
    LAMELLA_EMPTY_MESH = 4,
    LAMELLA_BAD_COORDINATE = 5,
    LAMELLA_BAD_PLANES = 6,
    LAMELLA_RESULT_TOO_LARGE = 7,
    LAMELLA_OUT_OF_MEMORY = 8,
    LAMELLA_CANCELLED = 9,
    LAMELLA_UNWRITABLE_FILE = 10
};

typedef struct lamella_error {
    uint32_t struct_size;
    int32_t status;
    int64_t triangle;    /* index of the offending triangle, or -1 */
    int64_t plane;       /* index of the offending plane, or -1 */
    int64_t byte_offset; /* where in a file, or -1 */
    char message[512];   /* one line, cut off where it is longer */
} lamella_error;

/* --- What a call may use of its host: lamella/control.hpp, lamella/memory.hpp */

/* Must outlive every handle that is filled by a call which takes it. */
typedef struct lamella_memory {
    void* (*allocate)(void* context, size_t bytes, size_t alignment); /* NULL where there are none */
    void (*release)(void* context, void* memory, size_t bytes, size_t alignment);
    void* context;
} lamella_memory;

typedef struct lamella_control {
    uint32_t struct_size;
    int32_t threads; /* at most this many; 0: all that the executor has */
    /* Calls body(argument) up to `workers` times, at once or one by one, and returns when they have. NULL: oneTBB. */
    void (*executor)(void* context, int32_t workers, void (*body)(void* argument), void* argument);
    void* executor_context;
    int32_t executor_threads;
    int32_t reserved;
    const lamella_memory* memory;   /* NULL: the C++ library's */
    int32_t (*stop)(void* context); /* not 0 ends the call with LAMELLA_CANCELLED; asked by several threads at once */
    void* stop_context;
    void (*progress)(void* context, double fraction); /* on any working thread, one call at a time; 1 in the last */
    void* progress_context;
} lamella_control;

/* --- The mesh: lamella/mesh.hpp */

enum { LAMELLA_F32 = 0, LAMELLA_F64 = 1, LAMELLA_I32 = 2, LAMELLA_I64 = 3 };
enum { LAMELLA_INDEX_U32 = 0, LAMELLA_INDEX_U64 = 1 };

/* A view of triangles where they lie. Without `indices` triangle t has nine numbers at vertices + t * vertex_stride; with
 * them vertex v has three at vertices + v * vertex_stride, and triangle t three indices at indices + t * index_stride. */
typedef struct lamella_mesh {
    uint32_t struct_size;
    int32_t coordinate_type; /* LAMELLA_F32 ... */
    const void* vertices;
    size_t vertex_stride; /* bytes; 0: packed */
    size_t vertex_count;  /* with indices only */
    const void* indices;  /* NULL: a soup */
    size_t index_stride;  /* bytes; 0: packed */
    int32_t index_type;   /* LAMELLA_INDEX_U32 ... */
    int32_t reserved;
    size_t triangle_count;
    double coordinate_mm; /* what 1 means in mm, for coordinates of any type; 1 by default */
} lamella_mesh;

/* --- Options: lamella/slice.hpp, lamella/planes.hpp, lamella/region.hpp */

enum { LAMELLA_LAYERS_UNIFORM = 0, LAMELLA_LAYERS_AT_HEIGHTS = 1 };
enum { LAMELLA_DATUM_MESH_MIN = 0, LAMELLA_DATUM_ZERO = 1 };
enum { LAMELLA_SIDE_BELOW = 0, LAMELLA_SIDE_ABOVE = 1 };
enum { LAMELLA_UNIT_AS_ASKED = 0, LAMELLA_UNIT_COARSER_IF_NEEDED = 1 };
enum { LAMELLA_ARITHMETIC_F64 = 0, LAMELLA_ARITHMETIC_AS_MESH = 1 };
enum { LAMELLA_GAP_SENSE_KEPT = 0, LAMELLA_GAP_SENSE_ANY = 1 };
enum {
    LAMELLA_FILL_CONTOURS = 0,
    LAMELLA_FILL_EVEN_ODD = 1,
    LAMELLA_FILL_NON_ZERO = 2,
    LAMELLA_FILL_POSITIVE = 3,
    LAMELLA_FILL_OUTERMOST = 4
};
enum { LAMELLA_PARTS_SEPARATE = 0, LAMELLA_PARTS_UNITED = 1 };

/* From this layer on another rule. */
typedef struct lamella_fill_from {
    uint64_t first_layer;
    int32_t fill_rule;
    int32_t reserved;
} lamella_fill_from;

typedef struct lamella_region_rules {
    uint32_t struct_size;
    int32_t fill_rule;
    const lamella_fill_from* fill_from;
    size_t fill_from_count;
    int32_t largest_only;
    int32_t drop_collinear;
    double close_mm;
    double offset_mm;
    double miter_limit;
    double mark_near_mm;
    double simplify_mm;
} lamella_region_rules;

#define LAMELLA_DEFAULT_UNIT_MM (1.0 / 1048576) /* lamella/grid.hpp: what unit_mm 0 stands for */
#define LAMELLA_UNIT_BY_BOX (-1.0)
#define LAMELLA_GAPS_BY_MESH (-1.0)
#define LAMELLA_GRID_LIMIT 1073741824 /* the largest magnitude of a point's x and y */

typedef struct lamella_options {
    uint32_t struct_size;
    int32_t spacing; /* LAMELLA_LAYERS_UNIFORM ... */
    double layer_height_mm;
    double first_height_mm;   /* NaN: the plane in the middle of each layer */
    int32_t datum;            /* LAMELLA_DATUM_MESH_MIN ... */
    int32_t side;             /* LAMELLA_SIDE_BELOW ... */
    const double* heights_mm; /* for LAMELLA_LAYERS_AT_HEIGHTS: in any order */
    size_t height_count;
    double unit_mm;       /* of the grid; 0: the default; LAMELLA_UNIT_BY_BOX: the finest that the mesh's box allows */
    double transform[12]; /* three rows of four, to mm: x' = t[0] x + t[1] y + t[2] z + t[3] */
    int32_t arithmetic;   /* LAMELLA_ARITHMETIC_F64 ... */
    int32_t unit_fit;     /* LAMELLA_UNIT_AS_ASKED ... */
    const lamella_region_rules* region; /* NULL: contours as the mesh gives them */
    double close_gaps_mm; /* 0: none; LAMELLA_GAPS_BY_MESH: a hundredth of the diagonal of the mesh's box */
    int32_t gap_sense; /* LAMELLA_GAP_SENSE_KEPT ... */
    int32_t allow_empty;
    uint64_t memory_limit_bytes;
    const lamella_control* control; /* NULL: oneTBB's threads, the C++ library's memory, no stop, no progress */
    int32_t origins;                /* not 0: say which triangle each contour edge comes from */
    int32_t reserved;
} lamella_options;

/* --- Results: lamella/result.hpp */

enum { LAMELLA_ROLE_OUTER = 0, LAMELLA_ROLE_HOLE = 1, LAMELLA_ROLE_FLAT = 2, LAMELLA_ROLE_OPEN = 3 };
enum { LAMELLA_ORIENTATION_OVERRULED = 1, LAMELLA_ORIENTATION_MIXED = 2, LAMELLA_GAP_CLOSED = 4, LAMELLA_NEAR_CONTOUR = 8 };

#define LAMELLA_SEVERAL_PARTS UINT32_MAX
#define LAMELLA_NO_TRIANGLE UINT32_MAX
#define LAMELLA_NO_EDGE 3

typedef struct lamella_point { /* grid units; times unit_mm they are mm */
    int32_t x;
    int32_t y;
} lamella_point;

typedef struct lamella_contour {
    uint64_t first_point;
    uint64_t twice_area_low; /* of a signed 128-bit integer, square grid units */
    int64_t twice_area_high;
    int64_t parent; /* index into contours, or -1 */
    uint32_t point_count;
    uint32_t segments;
    uint8_t role;       /* LAMELLA_ROLE_OUTER ... */
    int8_t orientation; /* 1 counter-clockwise, -1 clockwise */
    uint16_t flags;     /* LAMELLA_ORIENTATION_OVERRULED ... */
    uint32_t part;      /* or LAMELLA_SEVERAL_PARTS */
} lamella_contour;

/* Of a point and the contour edge that begins there. Edge e of a triangle leads from corner e to corner (e + 1) % 3. */
typedef struct lamella_point_origin {
    uint32_t triangle; /* index in the mesh, or LAMELLA_NO_TRIANGLE */
    uint16_t part;     /* index of that mesh among those of lamella_slice_parts() */
    uint8_t edge;      /* on which the contour edge begins, or LAMELLA_NO_EDGE */
    uint8_t end_edge;  /* and on which it ends */
} lamella_point_origin;

typedef struct lamella_layer {
    double bottom_mm;
    double plane_mm;
    double top_mm;
    uint64_t first_contour;
    uint64_t contour_count;
    uint64_t segments;
    int32_t plane; /* grid units */
    int32_t reserved;
} lamella_layer;

typedef struct lamella_closed_gap {
    uint64_t layer;
    lamella_point from;
    lamella_point to;
} lamella_closed_gap;

typedef struct lamella_view {
    uint32_t struct_size;
    int32_t unit_doublings; /* how often the unit asked for was doubled */
    double unit_mm;
    const lamella_layer* layers;
    uint64_t layer_count;
    const lamella_contour* contours;
    uint64_t contour_count;
    const lamella_point* points;
    uint64_t point_count;
    const lamella_closed_gap* closed_gaps;
    uint64_t closed_gap_count;
    const uint64_t* layer_of; /* of each height given its layer */
    uint64_t layer_of_count;
    uint64_t triangles;
    uint64_t degenerate; /* dropped: two equal vertices on the grid */
    uint64_t segments;
    uint64_t holes;
    uint64_t open_contours;
    uint64_t flat_contours;
    uint64_t overruled_contours;
    uint64_t near_contours;
    uint64_t emptied_layers;
    double min_mm[3];
    double max_mm[3];
    const lamella_point_origin* origins; /* of each point; NULL without lamella_options.origins */
} lamella_view;

typedef struct lamella_result lamella_result;
typedef struct lamella_workspace lamella_workspace;
typedef struct lamella_prepared lamella_prepared;

LAMELLA_C_API void lamella_result_view(const lamella_result* result, lamella_view* view);
/* Outers minus holes; NaN, not known, where the layer has an open contour. */
LAMELLA_C_API double lamella_result_area_mm2(const lamella_result* result, uint64_t layer);
LAMELLA_C_API uint64_t lamella_result_hash(const lamella_result* result);
LAMELLA_C_API void lamella_result_free(lamella_result* result);

/* mm2 within a contour: positive for an outer one, negative for a hole. */
LAMELLA_C_API double lamella_contour_area_mm2(const lamella_contour* contour, double unit_mm);

/* lamella/islands.hpp: an outer contour and the holes in it. */
typedef struct lamella_island {
    const lamella_contour* outer;
    const lamella_contour* holes;
    uint64_t hole_count;
} lamella_island;

/* The islands of a layer's contours one after the other, from `*at` = 0 on: 1, with the next one in `*island`, or 0 after
 * the last. */
LAMELLA_C_API int32_t lamella_next_island(const lamella_contour* contours, uint64_t contour_count, uint64_t* at,
                                          lamella_island* island);

/* --- Calls
 *
 * `options` may be NULL: the defaults. `*result` is NULL, or a result that is filled anew and whose memory is used again.
 * Where a call fails, NULL stays NULL, and what a given result holds is unspecified. */

/* Scratch that is kept from call to call, one for each thread that calls. NULL where there is no memory. */
LAMELLA_C_API lamella_workspace* lamella_workspace_create(void);
LAMELLA_C_API uint64_t lamella_workspace_bytes(const lamella_workspace* workspace);
LAMELLA_C_API void lamella_workspace_trim(lamella_workspace* workspace);
LAMELLA_C_API void lamella_workspace_reset(lamella_workspace* workspace);
LAMELLA_C_API void lamella_workspace_free(lamella_workspace* workspace);

/* lamella/slice.hpp. `workspace` may be NULL. */
LAMELLA_C_API int32_t lamella_slice(const lamella_mesh* mesh, const lamella_options* options, lamella_workspace* workspace,
                                    lamella_result** result, lamella_error* error);

/* lamella/parts.hpp. `transforms`: twelve numbers a mesh, or NULL. */
LAMELLA_C_API int32_t lamella_slice_parts(const lamella_mesh* const* meshes, const double* transforms, size_t count,
                                          const lamella_options* options, int32_t part_regions, lamella_result** result,
                                          lamella_error* error);

/* lamella/slabs.hpp: what upward and downward faces project onto each layer. `top` or `bottom` is NULL where it is not asked
 * for. Of `options` the fill rule of regions, gaps and origins must be left out. */
LAMELLA_C_API int32_t lamella_slice_slabs(const lamella_mesh* mesh, const lamella_options* options, lamella_result** top,
                                          lamella_result** bottom, lamella_error* error);

/* lamella/prepare.hpp. Of `options` transform, arithmetic, unit, allow_empty and control are used. */
LAMELLA_C_API int32_t lamella_prepare(const lamella_mesh* mesh, const lamella_options* options, lamella_prepared** prepared,
                                      lamella_error* error);
LAMELLA_C_API int32_t lamella_slice_prepared(const lamella_prepared* prepared, const lamella_options* options,
                                             lamella_workspace* workspace, lamella_result** result, lamella_error* error);
LAMELLA_C_API uint64_t lamella_prepared_bytes(const lamella_prepared* prepared);
LAMELLA_C_API double lamella_prepared_unit_mm(const lamella_prepared* prepared);
LAMELLA_C_API void lamella_prepared_free(lamella_prepared* prepared);

/* lamella/sink.hpp. */
enum { LAMELLA_SINK_ANY = 0, LAMELLA_SINK_ASCENDING = 1 };

/* Valid until the sink returns. Contours and parents are numbered within the layer. A library that is older than the program
 * gives a smaller struct_size, and no more fields than that. */
typedef struct lamella_layer_view {
    uint32_t struct_size;
    int32_t reserved;
    uint64_t index;
    double unit_mm;
    const lamella_layer* layer;
    const lamella_contour* contours;
    uint64_t contour_count;
    const lamella_point* points;
    uint64_t point_count;
    const lamella_closed_gap* closed_gaps;
    uint64_t closed_gap_count;
    const lamella_point_origin* origins; /* of each point; NULL without lamella_options.origins */
} lamella_layer_view;

typedef struct lamella_sink {
    void (*take)(void* context, const lamella_layer_view* layer); /* by several threads at once where order is any */
    void* context;
    int32_t order; /* LAMELLA_SINK_ANY ... */
    int32_t reserved;
} lamella_sink;

typedef struct lamella_totals {
    uint32_t struct_size;
    int32_t unit_doublings;
    double unit_mm;
    uint64_t layers;
    uint64_t contours;
    uint64_t points;
    uint64_t closed_gaps;
    uint64_t open_contours;
    uint64_t triangles;
    uint64_t degenerate;
    uint64_t segments;
    uint64_t holes;
    uint64_t flat_contours;
    uint64_t overruled_contours;
    uint64_t near_contours;
    uint64_t emptied_layers;
    double min_mm[3];
    double max_mm[3];
    uint64_t* layer_of;         /* the program's, filled in with the layer of each height given; or NULL */
    uint64_t layer_of_capacity; /* at least the number of heights */
} lamella_totals;

/* `workspace` and `totals` may be NULL. */
LAMELLA_C_API int32_t lamella_slice_to(const lamella_sink* sink, const lamella_mesh* mesh, const lamella_options* options,
                                       lamella_workspace* workspace, lamella_totals* totals, lamella_error* error);
LAMELLA_C_API int32_t lamella_slice_prepared_to(const lamella_sink* sink, const lamella_prepared* prepared,
                                                const lamella_options* options, lamella_workspace* workspace,
                                                lamella_totals* totals, lamella_error* error);

/* lamella/host_output.hpp. */
typedef struct lamella_output_bounds {
    uint32_t struct_size;
    int32_t are_certain;
    uint64_t layers;
    uint64_t contours;
    uint64_t points;
    uint64_t segments;
    double unit_mm;
} lamella_output_bounds;

typedef struct lamella_host_output {
    uint32_t struct_size;
    int32_t point_type; /* LAMELLA_F32 ... */
    void* points;
    uint64_t point_capacity;
    size_t point_stride; /* bytes; 0: packed */
    double scale;        /* the host's units in a grid unit */
    lamella_contour* contours;
    uint64_t contour_capacity;
    lamella_layer* layers;
    uint64_t layer_capacity;
    lamella_closed_gap* closed_gaps; /* NULL: they are only counted */
    uint64_t closed_gap_capacity;
    lamella_point_origin* origins; /* room for point_capacity, filled in with lamella_options.origins; NULL: none */
} lamella_host_output;

LAMELLA_C_API int32_t lamella_bound_output(const lamella_mesh* mesh, const lamella_options* options,
                                           lamella_workspace* workspace, lamella_output_bounds* bounds,
                                           lamella_error* error);
LAMELLA_C_API int32_t lamella_bound_prepared_output(const lamella_prepared* prepared, const lamella_options* options,
                                                    lamella_workspace* workspace, lamella_output_bounds* bounds,
                                                    lamella_error* error);
LAMELLA_C_API int32_t lamella_slice_into(const lamella_host_output* output, const lamella_mesh* mesh,
                                         const lamella_options* options, lamella_workspace* workspace,
                                         lamella_totals* totals, lamella_error* error);
LAMELLA_C_API int32_t lamella_slice_prepared_into(const lamella_host_output* output, const lamella_prepared* prepared,
                                                  const lamella_options* options, lamella_workspace* workspace,
                                                  lamella_totals* totals, lamella_error* error);

/* --- Contours that are not cut from a mesh. The result has one layer. */

typedef struct lamella_path {
    const lamella_point* points;
    size_t count;
} lamella_path;

/* lamella/region.hpp. `unit_mm` 0: the default. */
LAMELLA_C_API int32_t lamella_region_of(const lamella_path* contours, size_t count, const lamella_region_rules* rules,
                                        double unit_mm, const lamella_control* control, lamella_result** result,
                                        lamella_error* error);

typedef struct lamella_segment {
    uint64_t from_key[3];
    uint64_t to_key[3];
    lamella_point from;
    lamella_point to;
    uint32_t from_rank;
    uint32_t to_rank;
} lamella_segment;

/* lamella/assemble.hpp. */
LAMELLA_C_API int32_t lamella_assemble(const lamella_segment* segments, size_t count, const lamella_control* control,
                                       lamella_result** result, lamella_error* error);

/* --- Names, and structs with their defaults */

LAMELLA_C_API const char* lamella_version(void);               /* "0.2.0" */
LAMELLA_C_API const char* lamella_status_name(int32_t status); /* "bad_planes" */

LAMELLA_C_API void lamella_error_init_sized(lamella_error* error, size_t size);
LAMELLA_C_API void lamella_control_init_sized(lamella_control* control, size_t size);
LAMELLA_C_API void lamella_mesh_init_sized(lamella_mesh* mesh, size_t size);
LAMELLA_C_API void lamella_region_rules_init_sized(lamella_region_rules* rules, size_t size);
LAMELLA_C_API void lamella_options_init_sized(lamella_options* options, size_t size);
LAMELLA_C_API void lamella_view_init_sized(lamella_view* view, size_t size);
LAMELLA_C_API void lamella_totals_init_sized(lamella_totals* totals, size_t size);
LAMELLA_C_API void lamella_output_bounds_init_sized(lamella_output_bounds* bounds, size_t size);
LAMELLA_C_API void lamella_host_output_init_sized(lamella_host_output* output, size_t size);

/* These pass the size that the program was compiled with. */
#define lamella_error_init(error) lamella_error_init_sized((error), sizeof(lamella_error))
#define lamella_control_init(control) lamella_control_init_sized((control), sizeof(lamella_control))
#define lamella_mesh_init(mesh) lamella_mesh_init_sized((mesh), sizeof(lamella_mesh))
#define lamella_region_rules_init(rules) lamella_region_rules_init_sized((rules), sizeof(lamella_region_rules))
#define lamella_options_init(options) lamella_options_init_sized((options), sizeof(lamella_options))
#define lamella_view_init(view) lamella_view_init_sized((view), sizeof(lamella_view))
#define lamella_totals_init(totals) lamella_totals_init_sized((totals), sizeof(lamella_totals))
#define lamella_output_bounds_init(bounds) lamella_output_bounds_init_sized((bounds), sizeof(lamella_output_bounds))
#define lamella_host_output_init(output) lamella_host_output_init_sized((output), sizeof(lamella_host_output))

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* LAMELLA_LAMELLA_H */
