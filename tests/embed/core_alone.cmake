# The core builds where none of the packages is found that only lamella::io needs, and what it links does not bring them in.
#     cmake -DSOURCE=... -DFOLDER=... -DCOMPILER=... -DGENERATOR=... -DPARALLEL=tbb|std -P core_alone.cmake
execute_process(
  COMMAND ${CMAKE_COMMAND} --no-warn-unused-cli -S ${SOURCE} -B ${FOLDER} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER} -DLAMELLA_PARALLEL=${PARALLEL}
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=10
    -DBUILD_SHARED_LIBS=ON -DCMAKE_SHARED_LINKER_FLAGS=-Wl,--no-undefined
    -DLAMELLA_BUILD_IO=OFF -DLAMELLA_BUILD_TOOLS=OFF -DLAMELLA_BUILD_TESTS=OFF -DLAMELLA_BUILD_BENCH=OFF
    -DCMAKE_DISABLE_FIND_PACKAGE_EXPAT=ON -DCMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_FastFloat=ON -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${FOLDER} --parallel 2 OUTPUT_VARIABLE log ERROR_VARIABLE log RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "the core does not build alone:\n${log}")
endif()

find_program(readelf readelf REQUIRED)
file(GLOB_RECURSE libraries ${FOLDER}/liblamella*.so)
list(LENGTH libraries count)
if(NOT count EQUAL 1)
  message(FATAL_ERROR "one library was expected, not: ${libraries}")
endif()
execute_process(COMMAND ${readelf} -d ${libraries} OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
if(NOT dynamic MATCHES "NEEDED.*libc[.]so")
  message(FATAL_ERROR "readelf lists no libraries:\n${dynamic}")
endif()
if(dynamic MATCHES "NEEDED[^\n]*(expat|libz[.]|minizip|libzip)")
  message(FATAL_ERROR "the core links a package of lamella::io:\n${dynamic}")
endif()
