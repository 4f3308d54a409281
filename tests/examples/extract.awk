# Prints a C++ function for each example in the files named: of a header the first run of lines at its head that begin with
# "//     ", of a page every block between ```cpp and ```. What the examples take for granted are the function's parameters:
# a mesh and a result, and in pages options.
# The functions are listed at the end, with the place of each.
BEGIN {
    print "#include <cstdint>\n#include <cstdio>\n#include <cstdlib>\n#include <thread>\n#include <vector>\n"
    print "#include \"examples/examples.hpp\"\n#include \"lamella/io.hpp\"\n#include \"lamella/lamella.hpp\"\n#include \"lamella/medical.hpp\"\n"
}
FNR == 1 { end_file(); file = FILENAME; examples = 0; is_header = file ~ /[.]hpp$/; past_head = 0 }

is_header && /^#pragma once/ { end_example(); past_head = 1 }
is_header && !past_head && /^\/\/     / && (inside || examples == 0) { line(substr($0, 3)); next }
is_header { end_example(); next }

/^```/ && inside { end_example(); next }
/^```cpp$/ { in_page = 1; next }
in_page { line($0) }

END {
    end_file()
    print "const std::vector<Example>& all_examples() {\n    static const std::vector<Example> all = {"
    for (i = 1; i <= number; ++i) {
        print "        {\"" places[i] "\", example_" i "},"
    }
    print "    };\n    return all;\n}"
}

function line(text) {
    if (!inside) {
        inside = 1
        examples++
        print "void example_" ++number "([[maybe_unused]] const lamella::MeshView& mesh,"
        print "    [[maybe_unused]] const lamella::SliceResult& result, [[maybe_unused]] lamella::SliceOptions&" (is_header ? ") {" : " options) {")
        print "#line " FNR " \"" FILENAME "\""
        place = FILENAME
        sub(/.*\//, "", place)
        places[number] = place " " examples
    }
    print text
}
function end_example() {
    if (inside) {
        print "}\n"
    }
    inside = 0
    in_page = 0
}
function end_file() {
    end_example()
    if (file ~ /[.]hpp$/ && examples == 0) {
        print "#error \"no example at the head of " file "\""
    }
}
