# Prints the file NAME of a page: the block between ```c++ and ``` whose first line is "// NAME".
/^```c\+\+$/ { inside = 1; first = 1; next }
/^```/ { inside = 0; wanted = 0 }
inside && first { wanted = $0 == "// " NAME; first = 0; print_line() ; next }
inside { print_line() }
function print_line() {
    if (wanted) {
        print
    }
}
