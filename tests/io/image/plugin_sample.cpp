/// A plug-in for load_library_test.
extern "C" int sampleNumber() { return 42; }
