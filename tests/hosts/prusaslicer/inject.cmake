# Given to PrusaSlicer's build as CMAKE_PROJECT_PrusaSlicer_INCLUDE. Its targets do not exist yet at this point, so that the
# work waits for the end of its CMakeLists.txt. Variables in a deferred call are read only then: EVAL puts the folder in now.
cmake_language(EVAL CODE "cmake_language(DEFER CALL include [[${CMAKE_CURRENT_LIST_DIR}/host.cmake]])")
