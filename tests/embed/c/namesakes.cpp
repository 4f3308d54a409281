// A host with a clipping library, an XML parser and an inflater of its own: the names of those that others use, and other
// contents. It links if the library defines none of the names, and works if it calls none.
#include <cstdlib>

namespace ClipperLib {

struct IntPoint {
    char other_contents[40];
};

class Clipper {
public:
    virtual ~Clipper();
    virtual int Execute(int number);
    bool AddPath(const IntPoint& point, int type, bool closed);
};

Clipper::~Clipper() = default;
int Clipper::Execute(int number) {
    return number + 1;
}
bool Clipper::AddPath(const IntPoint&, int, bool) {
    std::abort();
}

}  // namespace ClipperLib

extern "C" {
int XML_ParserCreate(int number) {
    return number + 2;
}
int inflate(int number) {
    return number + 3;
}
int crc32(int number) {
    return number + 4;
}
void not_to_be_called() {
    std::abort();
}
void XML_Parse() __attribute__((alias("not_to_be_called")));
void XML_ParserFree() __attribute__((alias("not_to_be_called")));
void inflateInit2_() __attribute__((alias("not_to_be_called")));
void deflate() __attribute__((alias("not_to_be_called")));
void gzopen() __attribute__((alias("not_to_be_called")));
void zip_open() __attribute__((alias("not_to_be_called")));
}

namespace {

/// Whether the host's own functions are called.
bool own_are_called() {
    ClipperLib::Clipper clipper;
    return clipper.Execute(1) == 2 && XML_ParserCreate(1) == 3 && inflate(1) == 4 && crc32(1) == 5;
}

const bool checked_at_start = own_are_called() || (std::abort(), false);

}  // namespace
