/* A host's own expat, zlib and ClipperLib: the names of theirs, and none of their contents. */
#include <stdlib.h>

int inflate(void) { abort(); }
int deflate(void) { abort(); }
int gzopen(void) { abort(); }
int crc32(void) { abort(); }
int XML_ParserCreate(void) { abort(); }
int XML_Parse(void) { abort(); }
int _ZN10ClipperLib7Clipper7ExecuteEv(void) { abort(); }
