# Writes every block between ```hpp and ``` to a file in `folder`, under the name that its first line begins with:
# "// NAME: ...". Fails where a block has no name, and where the adapter is longer than the page says.
/^```hpp$/ { inside = 1; name = ""; next }
/^```/ && inside { inside = 0; close(folder "/" name); next }
inside && name == "" {
    if ($0 !~ /^\/\/ [a-z]+\.hpp: /) {
        print FILENAME ":" FNR ": a whole file begins with its name" > "/dev/stderr"
        exit 1
    }
    name = substr($2, 1, length($2) - 1)
    printf "" > (folder "/" name)
    lines[name] = 0
}
inside { print >> (folder "/" name); lines[name]++ }
END {
    if (lines["adapter.hpp"] >= 100) {
        print FILENAME ": the adapter has " lines["adapter.hpp"] " lines, which should be under 100" > "/dev/stderr"
        exit 1
    }
}
