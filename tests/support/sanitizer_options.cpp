// Known faults of OpenImageIO 2.4 that the sanitizers would report as ours, and one of their own.
// They read these where they are linked; elsewhere nobody calls them.
extern "C" const char* __asan_default_options();
extern "C" const char* __lsan_default_suppressions();

// Its texture system is freed by a sized delete of the wrong size, which no allocator here minds.
// The other option: up to g++ 13 and clang 16 the sanitizers take some variables of a thread for a
// block with a header of glibc before 2.25. Now and then the search for leaks then reads from no
// place at all and ends the program with "Tracer caught signal 11".
extern "C" const char* __asan_default_options() {
  return "new_delete_type_mismatch=0:intercept_tls_get_addr=0";
}

// libpng jumps over the destructor of an error's text when a PNG file ends too early.
extern "C" const char* __lsan_default_suppressions() { return "leak:basic_string*::_M_assign\n"; }
