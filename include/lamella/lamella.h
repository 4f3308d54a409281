/* lamella from C, and from every language that can call C.
 *
 *     const float soup[] = {0, 0, 0, 0, 9, 0, 9, 0, 0,  0, 0, 0, 9, 0, 0, 0, 0, 9,
 *                           0, 0, 0, 0, 0, 9, 0, 9, 0,  9, 0, 0, 0, 9, 0, 0, 0, 9};
 *     lamella_mesh mesh;
 *     LAMELLA_INIT(&mesh, LAMELLA_MESH);
 *     mesh.vertices = soup;
 *     mesh.triangle_count = 4;
 *     lamella_options options;
 *     LAMELLA_INIT(&options, LAMELLA_OPTIONS);
 *     options.layer_height_mm = 0.5;
 *     lamella_result* result = NULL;
 *     lamella_error error;
 *     LAMELLA_INIT(&error, LAMELLA_ERROR);
 *     if (lamella_slice(NULL, &mesh, &options, &result, &error) != LAMELLA_OK) {
 *         fprintf(stderr, "%s\n", error.message);
 *         return;
 *     }
 *     lamella_layer_view layer;
 *     LAMELLA_INIT(&layer, LAMELLA_LAYER_VIEW);
 *     for (uint64_t i = 0; lamella_result_layer(result, i, &layer) == LAMELLA_OK; ++i) {
 *         printf("z %g mm: %g mm2\n", layer.layer.plane_mm, lamella_area_mm2(&layer));
 *     }
 *     lamella_result_free(result);
 *
 * The shape is that of C++, whose headers say what each call does: a source is sliced by options within a context to a
 * destination. Here stands what C adds. lamella/overlay.h combines layers with layers, lamella/heights.h
 * chooses heights.
 *
 * Structs that begin with their size may grow. LAMELLA_INIT initialises them, those that a call fills too: one that was not
 * is refused, and void functions leave it alone. A library newer than the program gives fields that the program does not
 * know their defaults; an older one refuses a struct in which a field that it does not know is not 0. Fields named
 * `reserved` are 0. Structs without a size never change. Enumerations are kept in int32_t.
 *
 * Calls return a status, LAMELLA_OK or what went wrong; `error`, which may be NULL, then says more. A handle is given back
 * by its _free(), which takes NULL too. Views point into their handle, until it is filled anew or freed. No call throws,
 * prints, aborts or keeps global state. Callbacks must not throw or jump out: one that fails notes it, `stop` ends the call,
 * and the program looks at the note after it, whatever the status (tools/docs/embedding.md shows it in Python).
 *
 * A handle may be used by one thread at a time. But any number may slice a prepared mesh at once, each with a slicer and a
 * result of its own. */
#ifndef LAMELLA_LAMELLA_H
#define LAMELLA_LAMELLA_H

#include <stddef.h>
#include <stdint.h>

/* On Windows: exported where the library is compiled, and imported where LAMELLA_C_IMPORT says that its DLL is linked. */
#if defined(_WIN32) && defined(LAMELLA_C_EXPORT)
#define LAMELLA_C_API __declspec(dllexport)
#elif defined(_WIN32) && defined(LAMELLA_C_IMPORT)
#define LAMELLA_C_API __declspec(dllimport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define LAMELLA_C_API __attribute__((visibility("default")))
#else
#define LAMELLA_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* --- Status and errors */

enum { /* see lamella/error.hpp */
    LAMELLA_OK = 0, LAMELLA_INVALID_ARGUMENT = 1, LAMELLA_UNREADABLE_FILE = 2, LAMELLA_MALFORMED_MESH = 3,
    LAMELLA_EMPTY_MESH = 4, LAMELLA_BAD_COORDINATE = 5, LAMELLA_BAD_PLANES = 6, LAMELLA_RESULT_TOO_LARGE = 7,
    LAMELLA_OUT_OF_MEMORY = 8, LAMELLA_CANCELLED = 9, LAMELLA_UNWRITABLE_FILE = 10
};

typedef struct lamella_error {
    uint32_t struct_size;
    int32_t status;
    int64_t part, triangle, plane; /* indices of the offending ones, or -1 */
    int64_t byte_offset;           /* where in a file, or -1 */
    char message[512];             /* one line, cut off where it is longer */
} lamella_error;

/* --- What a call may use of its host: lamella/context.hpp */

/* Must outlive every handle that is filled by a call which takes it. */
typedef struct lamella_memory {
    void* allocate_object;
    void* (*allocate)(void* object, size_t bytes, size_t alignment); /* NULL where there are none */
    void* release_object;
    void (*release)(void* object, void* memory, size_t bytes, size_t alignment);
} lamella_memory;

typedef struct lamella_context {
    uint32_t struct_size;
    int32_t threads;               /* at most this many; 0: all that the executor has */
    int32_t (*stop)(void* object); /* not 0 ends the call with LAMELLA_CANCELLED; asked by several threads at once */
    void* stop_object;
    void (*progress)(void* object, double fraction); /* on any working thread, one call at a time; 1 in the last */
    void* progress_object;
    const lamella_memory* memory; /* NULL: the C++ library's */
    uint64_t memory_limit_bytes;  /* of a result; 0: half of physical memory */
    /* Calls body(argument) up to `workers` times, at once or one by one, and returns when they have. NULL: oneTBB. */
    void (*executor)(void* object, int32_t workers, void (*body)(void* argument), void* argument);
    void* executor_object;
    int32_t executor_threads, reserved;
} lamella_context;

/* --- The mesh: lamella/mesh.hpp */

enum { LAMELLA_F32 = 0, LAMELLA_F64 = 1, LAMELLA_I32 = 2, LAMELLA_I64 = 3, LAMELLA_U32 = 4, LAMELLA_U64 = 5 };

/* A view of triangles where they lie. Without `indices` triangle t has nine numbers at vertices + t * vertex_stride; with
 * them vertex v has three at vertices + v * vertex_stride, and triangle t three indices at indices + t * index_stride. */
typedef struct lamella_mesh {
    uint32_t struct_size;
    int32_t vertex_type; /* LAMELLA_F32 ... LAMELLA_I64 */
    const void* vertices;
    size_t vertex_count; /* with indices only */
    size_t triangle_count;
    const void* indices;  /* NULL: a soup */
    size_t vertex_stride; /* bytes; 0: packed */
    size_t index_stride;  /* bytes; 0: packed */
    double mm_per_unit;   /* of coordinates of any type; 1 by default */
    int32_t index_type;   /* LAMELLA_U32 by default, or LAMELLA_U64 */
    int32_t reserved;
} lamella_mesh;

typedef struct lamella_prepared lamella_prepared;

/* A mesh among several. */
typedef struct lamella_part {
    const lamella_mesh* mesh;
    double placement[12]; /* into the space that all parts share; all 0: it stays where it is */
} lamella_part;

/* What a part is for: lamella/source.hpp says what is left of each. */
enum { LAMELLA_SOLID = 0, LAMELLA_NEGATIVE = 1, LAMELLA_MODIFIER = 2, LAMELLA_SUPPORT_BLOCKER = 3, LAMELLA_SUPPORT_ENFORCER = 4,
       LAMELLA_SUPPORT = 5 };

/* What is cut: exactly one of mesh, prepared and parts is set. */
typedef struct lamella_source {
    uint32_t struct_size;
    int32_t reserved;
    const lamella_mesh* mesh;
    const lamella_prepared* prepared;
    const lamella_part* parts;
    size_t part_count;
    /* Of each part, or NULL: */
    const int32_t* part_roles;                    /* LAMELLA_SOLID, ...; NULL: all are solid */
    const uint32_t* part_objects;                 /* roles act among parts of the same number; NULL: all are of one object */
    const lamella_prepared* const* part_prepared; /* in place of the part's mesh where one is not NULL */
    const double* const* part_places; /* x, y and z in mm of each copy; where one is NULL, the part stays where it is */
    const size_t* part_place_counts;  /* copies, where part_places has some */
} lamella_source;

/* --- Options: lamella/options.hpp says what each does; here they are flat. Written by engine/options/generate.py */

/* begin choices */
enum { LAMELLA_STITCH_DIRECTION_ORIENTED = 0, LAMELLA_STITCH_DIRECTION_ANY = 1 };
enum { LAMELLA_LAYER_CONTENT_SECTION = 0, LAMELLA_LAYER_CONTENT_UPWARD_FACES = 1, LAMELLA_LAYER_CONTENT_DOWNWARD_FACES = 2 };
enum { LAMELLA_DATUM_MESH_MIN = 0, LAMELLA_DATUM_ZERO = 1 };
enum { LAMELLA_PLANE_SIDE_BELOW = 0, LAMELLA_PLANE_SIDE_ABOVE = 1 };
enum { LAMELLA_FILL_RULE_CONTOURS = 0, LAMELLA_FILL_RULE_EVEN_ODD = 1, LAMELLA_FILL_RULE_NON_ZERO = 2,
       LAMELLA_FILL_RULE_POSITIVE = 3, LAMELLA_FILL_RULE_OUTERMOST = 4 };
/* end choices */

#define LAMELLA_DEFAULT_GRID_MM (1.0 / 1048576) /* what grid_mm 0 stands for */
#define LAMELLA_FINEST_GRID (-1.0)
#define LAMELLA_STITCH_BY_MESH (-1.0)
#define LAMELLA_ALL_LAYERS UINT64_MAX
#define LAMELLA_GRID_LIMIT 1073741824 /* the largest magnitude of a point's x and y */

/* From this layer on another rule. */
typedef struct lamella_fill_from {
    uint64_t first_layer;
    int32_t fill_rule;
    int32_t reserved;
} lamella_fill_from;

/* The material between two heights. */
typedef struct lamella_slab {
    double bottom_mm, top_mm;
} lamella_slab;

typedef struct lamella_options {
    uint32_t struct_size;
    int32_t reserved;
    /* begin options */
    double layer_height_mm; /* Height of uniform layers. */
    const double* heights_mm; /* Cut at these heights instead, in any order; an empty list cuts nothing. */
    size_t height_count;
    const lamella_slab* slabs; /* Bottoms and tops of the layers, which are kept. */
    size_t slab_count;
    double stitch_mm; /* Join ends of open polylines at most so far apart, the nearest first; 0 joins none. */
    double first_height_mm; /* Height of the first plane above the datum; not given, half a layer. */
    uint64_t first_layer; /* Cut the layers of the plan from this one on only. */
    uint64_t end_layer; /* One past the last layer that is cut; may lie beyond the plan's end. */
    double transform[12]; /* From the mesh in mm to the space of planes and points: planes are horizontal after it. */
    double grid_mm; /* Step of the integer grid; 0: 2^-20 mm, doubled until the mesh fits. */
    double closing_mm; /* Fill gaps narrower than twice this, between contours and within one. */
    double offset_mm; /* Grow what is solid by so much, or shrink it where negative. */
    double miter_limit; /* Cut corners off that closing or offset would move farther than so many times its length. */
    double simplify_mm; /* Drop points that lie within so much of the lines left, last of all. */
    double flag_closing_mm; /* Flag contours that closing by so much would change, and change nothing. */
    const lamella_fill_from* fill_from; /* Other fill rules from these layers of the plan on, ascending. */
    size_t fill_from_count;
    int32_t at_heights;
    int32_t stitch_direction; /* Which ends of open polylines may be stitched. */
    int32_t origins; /* Say which triangle each contour edge comes from. */
    int32_t unite_parts; /* The rules of regions are done to all parts of a layer together, and not to each by itself. */
    int32_t share_copies; /* Copies of a part (Part::at_mm) at one height share the contours of the first of them. */
    int32_t allow_empty; /* A mesh without triangles, or of which none is left on the grid, is no error. */
    int32_t content; /* What a layer shows: the section at its plane, or what faces project onto it. */
    int32_t datum; /* Where heights of uniform layers count from: the mesh's lowest vertex, or z = 0. */
    int32_t side; /* Where a plane passes a vertex of exactly its height. */
    int32_t coarser_if_needed; /* A grid that is too fine for the mesh is doubled until it fits, instead of refused. */
    /* The transform is computed in floats where the mesh has floats, and heights are rounded to floats. */
    int32_t as_mesh_numbers;
    int32_t fill_rule; /* What is solid where contours overlap, nest in the same direction or run backwards. */
    int32_t drop_collinear; /* Drop points exactly on the line between their neighbours. */
    int32_t largest_only; /* Keep the outer contour of the largest area of a layer only, with its holes. */
    /* end options */
} lamella_options;

/* --- Results: lamella/result.hpp */

enum { LAMELLA_ROLE_OUTER = 0, LAMELLA_ROLE_HOLE = 1, LAMELLA_ROLE_FLAT = 2, LAMELLA_ROLE_OPEN = 3 };
enum { LAMELLA_ORIENTATION_OVERRULED = 1, LAMELLA_ORIENTATION_MIXED = 2, LAMELLA_STITCHED = 4, LAMELLA_WOULD_CLOSE = 8 };

#define LAMELLA_SEVERAL_PARTS UINT32_MAX
#define LAMELLA_NO_TRIANGLE UINT32_MAX
#define LAMELLA_NO_EDGE 3
typedef struct lamella_point { int32_t x, y; } lamella_point; /* grid units; times grid_mm they are mm */

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
    uint16_t part;     /* index of that mesh among the parts */
    uint8_t edge;      /* on which the contour edge begins, or LAMELLA_NO_EDGE */
    uint8_t end_edge;  /* and on which it ends */
} lamella_point_origin;

typedef struct lamella_layer {
    double bottom_mm, plane_mm, top_mm;
    uint64_t first_contour, contour_count, segments;
    int32_t plane; /* grid units */
    int32_t reserved;
} lamella_layer;

typedef struct lamella_stitch {
    uint64_t layer;
    lamella_point from, to;
} lamella_stitch;

/* A part whose contours are those of part `first`, moved by `move`. */
typedef struct lamella_part_copy { uint32_t part, first; lamella_point move; } lamella_part_copy;

/* What is known of a slice but its layers. */
typedef struct lamella_info {
    uint32_t struct_size;
    int32_t grid_doublings; /* how often the step asked for was doubled */
    double grid_mm;
    double min_mm[3], max_mm[3]; /* box of the transformed mesh */
    double stitch_mm; /* as asked, or by the mesh, in mm */
    uint64_t part_count;
    uint64_t first_layer; /* of the first layer among those of the plan */
    uint64_t planned_layers;
    uint64_t triangles, degenerate; /* of which dropped: two equal vertices on the grid */
    uint64_t crossed, layers, segments;
    uint64_t contours, points, stitches, holes; /* from here on known at the end only */
    uint64_t open_contours, flat_contours, overruled_contours, would_close_contours;
    uint64_t emptied_layers, cancelled_layers;
    const uint64_t* layer_of; /* the layer of each height given: of the result, or of the slicer or overlay until its next call */
    uint64_t layer_of_count;
    const lamella_part_copy* copies; /* with share_copies: those that are not in the layers; lives as long as layer_of */
    uint64_t copy_count;
} lamella_info;

/* One layer, of a result or in a sink, where it is valid until the sink returns. The points of a contour c are
 * points + (c->first_point - first_point), those of parent p contours + (p - layer.first_contour). */
typedef struct lamella_layer_view {
    uint32_t struct_size;
    int32_t reserved;
    uint64_t index;
    double grid_mm;
    lamella_layer layer;
    const lamella_contour* contours;
    const lamella_point* points;
    uint64_t point_count;
    uint64_t first_point;
    const lamella_point_origin* origins; /* of each point; NULL without lamella_options.origins */
    const lamella_stitch* stitches;
    uint64_t stitch_count;
} lamella_layer_view;

/* Net solid area; NaN, not known, where a contour is open. */
LAMELLA_C_API double lamella_area_mm2(const lamella_layer_view* layer);
/* Within a contour: positive for an outer one, negative for a hole. */
LAMELLA_C_API double lamella_contour_area_mm2(const lamella_contour* contour, double grid_mm);

/* An outer contour and the holes in it. */
typedef struct lamella_island {
    const lamella_contour *outer, *holes;
    uint64_t hole_count;
} lamella_island;

/* The islands of a layer's contours in turn, from `*at` = 0 on: 1 with the next in `*island`, or 0 after the last. */
LAMELLA_C_API int32_t lamella_next_island(const lamella_contour* contours, uint64_t contour_count, uint64_t* at,
                                          lamella_island* island);

typedef struct lamella_result lamella_result;

/* All of a result, in the flat arrays that contours and points index. */
typedef struct lamella_view {
    uint32_t struct_size;
    int32_t reserved;
    const lamella_layer* layers;
    const lamella_contour* contours;
    const lamella_point* points;
    const lamella_point_origin* origins; /* of each point; NULL without lamella_options.origins */
    const lamella_stitch* stitches;
    lamella_info info;
} lamella_view;

LAMELLA_C_API void lamella_result_view(const lamella_result* result, lamella_view* view);
/* LAMELLA_INVALID_ARGUMENT past the last layer. */
LAMELLA_C_API int32_t lamella_result_layer(const lamella_result* result, uint64_t layer, lamella_layer_view* view);
LAMELLA_C_API uint64_t lamella_result_hash(const lamella_result* result);
LAMELLA_C_API void lamella_result_free(lamella_result* result);

/* --- Where layers go: lamella/destination.hpp */

enum { LAMELLA_SINK_ASCENDING = 0, LAMELLA_SINK_ANY = 1 };

typedef struct lamella_sink {
    uint32_t struct_size;
    int32_t order; /* LAMELLA_SINK_ASCENDING ... */
    void (*take)(void* object, const lamella_layer_view* layer); /* by several threads at once where order is any */
    void (*begin)(void* object, const lamella_info* info);       /* before the first layer; or NULL */
    void* object;
} lamella_sink;

typedef struct lamella_arrays {
    uint32_t struct_size;
    int32_t point_type; /* LAMELLA_I32, LAMELLA_I64, LAMELLA_F32 or LAMELLA_F64 */
    void* points;
    uint64_t point_capacity;
    size_t point_stride; /* bytes; 0: packed */
    double scale;        /* the host's units in a grid unit */
    lamella_contour* contours;
    uint64_t contour_capacity;
    lamella_layer* layers;
    uint64_t layer_capacity;
    lamella_stitch* stitches; /* NULL: they are only counted */
    uint64_t stitch_capacity;
    lamella_point_origin* origins; /* room for point_capacity, filled in with lamella_options.origins; NULL: none */
} lamella_arrays;

/* Exactly one is set. */
typedef struct lamella_destination {
    uint32_t struct_size;
    int32_t reserved;
    lamella_result** result; /* *result is NULL, or a result that is filled anew and whose memory is used again */
    const lamella_sink* sink;
    const lamella_arrays* arrays;
} lamella_destination;

/* --- Slicing: lamella/slice.hpp
 *
 * Slicer, options, context, info and error may be NULL. Where a call fails, a result that was NULL stays NULL, and what a
 * given one holds is unspecified. */

typedef struct lamella_slicer lamella_slicer;

/* Scratch that is kept from call to call, one for each thread that calls. NULL where there is no memory. */
LAMELLA_C_API lamella_slicer* lamella_slicer_create(void);
LAMELLA_C_API uint64_t lamella_slicer_bytes(const lamella_slicer* slicer);
LAMELLA_C_API void lamella_slicer_trim(lamella_slicer* slicer);
LAMELLA_C_API void lamella_slicer_reset(lamella_slicer* slicer);
LAMELLA_C_API void lamella_slicer_free(lamella_slicer* slicer);
/* Takes and touches scratch for so many triangles that are cut, and starts threads, so that the first slice need not. */
LAMELLA_C_API int32_t lamella_slicer_make_ready(lamella_slicer* slicer, uint64_t triangles, const lamella_context* context,
                                                lamella_error* error);

/* The usual case of the next. */
LAMELLA_C_API int32_t lamella_slice(lamella_slicer* slicer, const lamella_mesh* mesh, const lamella_options* options,
                                    lamella_result** result, lamella_error* error);
LAMELLA_C_API int32_t lamella_slice_to(lamella_slicer* slicer, const lamella_destination* to, const lamella_source* from,
                                       const lamella_options* options, const lamella_context* context, lamella_info* info,
                                       lamella_error* error);
LAMELLA_C_API int32_t lamella_outline(lamella_slicer* slicer, const lamella_source* from, const lamella_options* options,
                                      const lamella_context* context, lamella_info* info, lamella_error* error);

/* Of `options` those of the frame are used. What the mesh views must outlive the handle, unchanged. */
LAMELLA_C_API int32_t lamella_prepare(const lamella_mesh* mesh, const lamella_options* options,
                                      const lamella_context* context, lamella_prepared** prepared, lamella_error* error);
LAMELLA_C_API uint64_t lamella_prepared_bytes(const lamella_prepared* prepared);
LAMELLA_C_API double lamella_prepared_grid_mm(const lamella_prepared* prepared);
LAMELLA_C_API void lamella_prepared_free(lamella_prepared* prepared);

/* --- Contours that are not cut from a mesh: lamella/layers.hpp. The result has one layer. */

typedef struct lamella_path {
    const lamella_point* points;
    size_t count;
} lamella_path;

/* Of `options` the rules of regions are used. `grid_mm` 0: the default. */
LAMELLA_C_API int32_t lamella_region_of(const lamella_path* contours, size_t count, const lamella_options* options,
                                        double grid_mm, const lamella_context* context, lamella_result** result,
                                        lamella_error* error);

typedef struct lamella_segment {
    uint64_t from_key[3], to_key[3];
    lamella_point from, to;
    uint32_t from_rank, to_rank;
} lamella_segment;

LAMELLA_C_API int32_t lamella_assemble(const lamella_segment* segments, size_t count, const lamella_context* context,
                                       lamella_result** result, lamella_error* error);

/* --- Is the mesh sound, and the result right? lamella/check.hpp, lamella/weld.hpp, lamella/audit.hpp */

typedef struct lamella_check_result {
    uint32_t struct_size;
    int32_t closed;   /* every edge has as many faces one way as the other */
    int32_t clean;    /* no fault was found but slivers; 0 with `counts_only` */
    int32_t complete; /* no search was cut short */
    uint64_t triangles, degenerate;
    uint64_t edges, boundary_edges, overfull_edges, mismatched_edges, shells;
    double min_mm[3], max_mm[3];
    double volume_mm3, area_mm2, grid_mm;
    uint64_t faults[20]; /* of each kind, in the order of lamella::Fault */
} lamella_check_result;

/* Of `options` those of the frame are used. With `counts_only` sooner, and without faults. */
LAMELLA_C_API int32_t lamella_check(const lamella_mesh* mesh, const lamella_options* options, int32_t counts_only,
                                    const lamella_context* context, lamella_check_result* found, lamella_error* error);

typedef struct lamella_welded lamella_welded;

/* Joins vertices at most `tolerance_mm` apart, and with `orient_shells` turns closed shells the right way round. */
LAMELLA_C_API int32_t lamella_weld(const lamella_mesh* mesh, double tolerance_mm, int32_t orient_shells,
                                   const lamella_context* context, lamella_welded** welded, lamella_error* error);
LAMELLA_C_API void lamella_welded_mesh(const lamella_welded* welded, lamella_mesh* mesh);
LAMELLA_C_API void lamella_welded_free(lamella_welded* welded);

enum {
    LAMELLA_VOLUME_NOT_ASKED = -1, LAMELLA_VOLUME_HOLDS = 0, LAMELLA_VOLUME_AREAS_DIFFER = 1,
    LAMELLA_VOLUME_VOLUMES_DIFFER = 2, LAMELLA_VOLUME_OPEN_MESH = 3, LAMELLA_VOLUME_NOT_AS_WALKED = 4,
    LAMELLA_VOLUME_SOLID_DIFFERS = 5
};

typedef struct lamella_audit_result {
    uint32_t struct_size;
    int32_t volume; /* LAMELLA_VOLUME_NOT_ASKED ... */
    double mesh_mm3, slabs_mm3;
    uint64_t open_layers;
    double open_share; /* of the crossed height */
    double stitch_mm;  /* would close them, but `stuck_layers` */
    uint64_t stuck_layers;
    uint64_t triangles_between_planes, shells_between_planes, crossings;
    int32_t structure; /* LAMELLA_OK; else not as slicing makes results; -1: not asked */
    int32_t reserved;
} lamella_audit_result;

/* `mesh` is what was sliced. NULL: volumes are not asked for, and nothing is counted between planes. */
LAMELLA_C_API int32_t lamella_audit(const lamella_result* result, const lamella_mesh* mesh, const lamella_context* context,
                                    lamella_audit_result* found, lamella_error* error);

/* --- Names, and structs with their defaults */

LAMELLA_C_API const char* lamella_version(void);               /* "0.3.0" */
LAMELLA_C_API const char* lamella_status_name(int32_t status); /* "bad_planes" */

enum {
    LAMELLA_ERROR = 0, LAMELLA_CONTEXT = 1, LAMELLA_MESH = 2, LAMELLA_SOURCE = 3, LAMELLA_OPTIONS = 4, LAMELLA_INFO = 5,
    LAMELLA_LAYER_VIEW = 6, LAMELLA_VIEW = 7, LAMELLA_SINK = 8, LAMELLA_ARRAYS = 9, LAMELLA_DESTINATION = 10,
    LAMELLA_CHECK_RESULT = 11, LAMELLA_AUDIT_RESULT = 12, LAMELLA_LAYER_SET = 13, LAMELLA_RULE = 14, LAMELLA_ADAPTIVE = 15, LAMELLA_OFFSET = 16
};

/* Sets the struct that `it` points to, one of the above, to its defaults; an unknown kind to zeros. */
LAMELLA_C_API void lamella_init_sized(void* it, int32_t kind, size_t size);
/* Passes the size that the program was compiled with. */
#define LAMELLA_INIT(it, kind) lamella_init_sized((it), (kind), sizeof *(it))

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* LAMELLA_LAMELLA_H */
