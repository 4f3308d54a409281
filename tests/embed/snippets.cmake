# readme_snippet(LANGUAGE FILE): the one fenced block of that language in README.md, as a file.
function(readme_snippet language file)
  cmake_path(GET file PARENT_PATH folder)
  file(MAKE_DIRECTORY ${folder})
  execute_process(
    COMMAND sed -n "/^```${language}$/,/^```$/p" ${LAMELLA_README}
    COMMAND sed "/^```/d"
    OUTPUT_FILE ${file} COMMAND_ERROR_IS_FATAL ANY)
  file(SIZE ${file} size)
  if(size EQUAL 0)
    message(FATAL_ERROR "README.md shows no ${language}")
  endif()
endfunction()
