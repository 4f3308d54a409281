# Within PrusaSlicer's build: optimises what is timed and, with LAMELLA_ADAPTER, puts the adapter in the place of the host's
# slicing. The host's sources stay as they are.
#
# The host is built with -O1, which saves minutes. What is timed gets -O3 on both sides.
set(libslic3r_folder ${CMAKE_SOURCE_DIR}/src/libslic3r)
set(timed TriangleMeshSlicer TriangleMesh ClipperUtils clipper ExPolygon Polygon MultiPoint Polyline Point BoundingBox)
list(TRANSFORM timed PREPEND ${libslic3r_folder}/)
list(TRANSFORM timed APPEND .cpp)
set_source_files_properties(${timed} TARGET_DIRECTORY libslic3r PROPERTIES COMPILE_OPTIONS -O3)

option(LAMELLA_ADAPTER "Slice by lamella" OFF)
if(NOT LAMELLA_ADAPTER)
  return()
endif()

find_package(lamella REQUIRED)
set(adapter_folder ${CMAKE_CURRENT_LIST_DIR})

# The host's own functions stay in the library under other names, for comparison and for what calls them in their file.
set_source_files_properties(${libslic3r_folder}/TriangleMeshSlicer.cpp TARGET_DIRECTORY libslic3r PROPERTIES
  COMPILE_DEFINITIONS "slice_mesh=slice_mesh_host;slice_mesh_ex=slice_mesh_ex_host;slice_mesh_slabs=slice_mesh_slabs_host")

# A library of its own: the host is C++17.
add_library(lamella_adapter STATIC ${adapter_folder}/adapter.cpp)
target_compile_features(lamella_adapter PRIVATE cxx_std_20)
target_compile_options(lamella_adapter PRIVATE -O3)
target_link_libraries(lamella_adapter PRIVATE libslic3r lamella::lamella)
target_link_libraries(libslic3r lamella_adapter)

add_executable(lamella_compare ${adapter_folder}/compare.cpp ${adapter_folder}/agreement.cpp ${adapter_folder}/operations.cpp)
target_compile_features(lamella_compare PRIVATE cxx_std_20)
target_compile_options(lamella_compare PRIVATE -O3)
target_link_libraries(lamella_compare PRIVATE libslic3r lamella::lamella)
