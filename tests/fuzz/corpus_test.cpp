// What fuzzing has found, and small whole files, read again by the readers they were found with: nothing crashes, and
// nothing but slicemorph::Error is thrown.
#include "targets.h"

#include "slicemorph/io/vdb_reader.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace slicemorph::fuzz {
namespace {

const std::filesystem::path kCorpus = SLICEMORPH_SOURCE "/tests/fuzz/corpus";

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Corpus, EveryFolderIsATarget) {
  for (const auto& folder : std::filesystem::directory_iterator(kCorpus))
    EXPECT_TRUE(targetNamed(folder.path().filename().string())) << folder.path();
}

class OfTarget : public testing::TestWithParam<Target> {};

TEST_P(OfTarget, NothingCrashes) {
  initialiseVdb();
  const std::filesystem::path folder = kCorpus / GetParam().name;
  ASSERT_TRUE(std::filesystem::is_directory(folder));
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    const std::string bytes = bytesOf(file.path());
    EXPECT_NO_THROW(run(GetParam(), bytes)) << file.path();
    // Cut short: a third and all but the last byte of it.
    EXPECT_NO_THROW(run(GetParam(), bytes.substr(0, bytes.size() / 3))) << file.path();
    EXPECT_NO_THROW(run(GetParam(), bytes.substr(0, bytes.empty() ? 0 : bytes.size() - 1))) << file.path();
  }
}

std::string nameOf(const testing::TestParamInfo<Target>& info) {
  std::string name = info.param.name;
  for (char& letter : name)
    if (letter == '-') letter = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Fuzz, OfTarget, testing::ValuesIn(targets()), nameOf);

}  // namespace
}  // namespace slicemorph::fuzz
