#include "io/image/load_library.h"

#include "slicemorph/errors.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// This program is in another folder than the shared library whose code looks for plug-ins (plugin_finder);
/// plugin_sample.cpp is a plug-in beside that library, in SAMPLE_FOLDER.
int numberOfSample() {
  return reinterpret_cast<int (*)()>(functionOfPlugin("libplugin_sample.so", "sampleNumber", "samples"))();
}

IoError refusal(const std::string& library, const char* function) {
  try {
    functionOfPlugin(library, function, "samples");
  } catch (const IoError& error) {
    return error;
  }
  return IoError("it was found");
}

TEST(LoadLibrary, PluginsBesideTheLibrarysOwnFileAreFound) {
  ASSERT_NE(fs::read_symlink("/proc/self/exe").parent_path(), fs::path(SAMPLE_FOLDER));
  EXPECT_EQ(numberOfSample(), 42);
}

TEST(LoadLibrary, TheVariableNamesTheOnlyPlace) {
  ::setenv("SLICEMORPH_PLUGINS", SAMPLE_FOLDER, 1);
  EXPECT_EQ(numberOfSample(), 42);
  ::setenv("SLICEMORPH_PLUGINS", "/nowhere", 1);
  const IoError error = refusal("libplugin_sample.so", "sampleNumber");
  EXPECT_EQ(error.note().about, "libplugin_sample.so");
  EXPECT_NE(error.note().text.find("looked in /nowhere;"), std::string::npos) << error.what();
  ::unsetenv("SLICEMORPH_PLUGINS");
}

TEST(LoadLibrary, WhatIsMissingIsNamed) {
  const IoError missing = refusal("libthere_is_none.so", "sampleNumber");
  EXPECT_EQ(missing.note().about, "libthere_is_none.so");
  EXPECT_NE(missing.note().text.find(SAMPLE_FOLDER), std::string::npos) << missing.what();
  EXPECT_NE(missing.note().text.find("SLICEMORPH_PLUGINS"), std::string::npos) << missing.what();
  const IoError strange = refusal("libplugin_sample.so", "noSuchFunction");
  EXPECT_EQ(strange.note().about, SAMPLE_FOLDER "/libplugin_sample.so");
  EXPECT_NE(strange.note().text.find("noSuchFunction"), std::string::npos) << strange.what();
}

}  // namespace
}  // namespace slicemorph
