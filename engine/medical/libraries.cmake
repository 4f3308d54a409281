# lamella::medical: which folders are compiled, by the libraries that are there. A folder whose library is missing consists of
# its absent.cpp, which refuses the format by name.

find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PNG)
find_path(LAMELLA_NIFTI_INCLUDE nifti1.h PATH_SUFFIXES nifti)
pkg_check_modules(hdf5 IMPORTED_TARGET hdf5-serial)

# HDF5 is linked statically: the shared library of Debian loads libcurl and 30 others, which takes half of the time that a
# small slice takes.
find_library(LAMELLA_HDF5_ARCHIVE libhdf5.a HINTS ${hdf5_LIBRARY_DIRS} NO_CMAKE_FIND_ROOT_PATH)
find_library(LAMELLA_SZIP NAMES sz aec)
if(hdf5_FOUND AND LAMELLA_HDF5_ARCHIVE AND LAMELLA_SZIP)
  add_library(lamella_hdf5 INTERFACE)
  target_include_directories(lamella_hdf5 SYSTEM INTERFACE ${hdf5_INCLUDE_DIRS})
  target_link_libraries(lamella_hdf5 INTERFACE ${LAMELLA_HDF5_ARCHIVE} ${LAMELLA_SZIP} ZLIB::ZLIB ${CMAKE_DL_LIBS} m)
endif()

# Of DCMTK only the data sets. Its pkg-config file asks for libraries that Debian does not install with it.
find_path(LAMELLA_DCMTK_INCLUDE dcmtk/dcmdata/dctk.h)
find_library(LAMELLA_DCMDATA dcmdata)
find_library(LAMELLA_OFLOG oflog)
find_library(LAMELLA_OFSTD ofstd)
if(LAMELLA_DCMTK_INCLUDE AND LAMELLA_DCMDATA AND LAMELLA_OFLOG AND LAMELLA_OFSTD)
  add_library(lamella_dcmtk INTERFACE)
  target_include_directories(lamella_dcmtk SYSTEM INTERFACE ${LAMELLA_DCMTK_INCLUDE})
  target_link_libraries(lamella_dcmtk INTERFACE ${LAMELLA_DCMDATA} ${LAMELLA_OFLOG} ${LAMELLA_OFSTD})
endif()

if(LAMELLA_NIFTI_INCLUDE)
  add_library(lamella_nifti INTERFACE)
  target_include_directories(lamella_nifti SYSTEM INTERFACE ${LAMELLA_NIFTI_INCLUDE})
endif()

set(LAMELLA_MEDICAL_SOURCES "")
set(LAMELLA_MEDICAL_LIBRARIES OpenSSL::Crypto ZLIB::ZLIB)

# medical_folder FOLDER [TARGET]: its sources, if the target is there or none is named, else its absent.cpp.
function(medical_folder folder)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/medical/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/absent[.]cpp$")
  if(NOT sources)
    file(GLOB sources ${CMAKE_CURRENT_SOURCE_DIR}/medical/${folder}/absent.cpp)
  endif()
  if(ARGC GREATER 1 AND NOT TARGET ${ARGV1})
    set(sources ${CMAKE_CURRENT_SOURCE_DIR}/medical/${folder}/absent.cpp)
    message(STATUS "lamella::medical is built without ${folder}: ${ARGV1} was not found")
  elseif(ARGC GREATER 1)
    list(APPEND LAMELLA_MEDICAL_LIBRARIES $<BUILD_INTERFACE:${ARGV1}>)
  endif()
  set(LAMELLA_MEDICAL_SOURCES ${LAMELLA_MEDICAL_SOURCES} ${sources} PARENT_SCOPE)
  set(LAMELLA_MEDICAL_LIBRARIES ${LAMELLA_MEDICAL_LIBRARIES} PARENT_SCOPE)
endfunction()
