# Makes the comment at the head of a header one that Doxygen reads. Indented lines become code.
FNR == 1 { print "/// @file" }
/^#pragma once/ { past_head = 1 }
!past_head && /^\/\// { print "/" $0; next }
{ print }
