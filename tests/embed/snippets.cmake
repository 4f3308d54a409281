# readme_snippet(LANGUAGE FILE [NUMBER]): the first fenced block of that language in README.md, or the one of that number, as a file.
function(readme_snippet language file)
  cmake_path(GET file PARENT_PATH folder)
  file(MAKE_DIRECTORY ${folder})
  execute_process(
    COMMAND awk -v "fence=```${language}" -v number=${ARGV2}
      "BEGIN { number += !number } /^```/ { on = !on && $0 == fence && ++at == number; next } on" ${LAMELLA_README}
    OUTPUT_FILE ${file} COMMAND_ERROR_IS_FATAL ANY)
  file(SIZE ${file} size)
  if(size EQUAL 0)
    message(FATAL_ERROR "README.md shows no ${language}")
  endif()
endfunction()
