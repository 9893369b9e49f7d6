// Known faults of OpenImageIO 2.4 that the sanitizers would report as ours. They read these where
// they are linked; elsewhere nobody calls them.
extern "C" const char* __asan_default_options();
extern "C" const char* __lsan_default_suppressions();

// Its texture system is freed by a sized delete of the wrong size, which no allocator here minds.
extern "C" const char* __asan_default_options() { return "new_delete_type_mismatch=0"; }

// libpng jumps over the destructor of an error's text when a PNG file ends too early.
extern "C" const char* __lsan_default_suppressions() { return "leak:basic_string*::_M_assign\n"; }
