#include "tools/job/job_file.h"
#include "tools/job/job_writer.h"
#include "tools/job/option_set.h"
#include "tools/job/option_table.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

namespace slicemorph {
namespace {

const Command kCommands[] = {kMorph,   kSlice, kReconstruct, kConvert, kRender,
                             kCompare, kInfo,  kDemo,        kPick,    kSurvey};

bool isNumber(const OptionRow& row) {
  return row.type == OptionType::kInteger || row.type == OptionType::kNumber;
}

/// A row's error for a value; empty: the value is accepted.
std::string faultOf(const OptionRow& row, const std::string& text) {
  JobOptions options;
  try {
    setField(row, {text}, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// A text that the row accepts and that is not its default.
std::string someValue(const OptionRow& row) {
  if (row.type == OptionType::kFlag) return "true";
  if (!row.choices.empty()) return row.choices.back();
  if (!isNumber(row)) return "other";
  const double least = std::isfinite(row.range.least) ? row.range.least : 1;
  const std::string near = std::to_string(int(std::ceil(least)) + 1);
  return near == defaultOf(row) ? std::to_string(int(std::ceil(least))) : near;
}

const OptionRow& morphRow(const std::string& name) {
  static const OptionSet options(kMorph);
  return options.row(name);
}

TEST(OptionTable, NamesAreUniqueInEveryCommand) {
  for (const Command command : kCommands) {
    const OptionSet options(command);
    std::set<std::string> names;
    for (const OptionRow* row : options.rows())
      EXPECT_TRUE(names.insert(row->name).second) << row->name << " twice in command " << command;
  }
}

TEST(OptionTable, RowsSayWhatTheHelpNeeds) {
  for (const OptionRow& row : optionTable()) {
    if (!row.field) continue;  // tables of job files
    EXPECT_NE(row.commands, 0u) << row.name;
    EXPECT_FALSE(row.help.empty()) << row.name;
    const bool dashes = row.positional.empty();
    EXPECT_EQ(formOf(row).empty(), row.type == OptionType::kFlag || !dashes) << row.name;
    if (dashes && !row.required) {
      EXPECT_NE(helpOf(row).find("default "), std::string::npos) << helpOf(row);
    }
    if (!row.unit.empty()) {
      EXPECT_NE(helpOf(row).find(row.unit), std::string::npos) << helpOf(row);
    }
  }
}

TEST(OptionTable, WhatExcludesAndSilencesIsThere) {
  for (const Command command : kCommands) {
    const OptionSet options(command);
    for (const OptionRow* row : options.rows())
      for (const auto* names : {&row->excludes, &row->silencedBy})
        for (const std::string& name : *names) EXPECT_NO_THROW(options.row(name)) << row->name;
  }
}

TEST(OptionTable, DefaultsAreValuesOfTheirOptions) {
  for (const OptionRow& row : optionTable()) {
    if (!row.field || defaultOf(row).empty()) continue;
    EXPECT_EQ(faultOf(row, defaultOf(row)), "") << row.name;
  }
}

TEST(OptionTable, EveryRowIsBoundToAFieldOfItsOwn) {
  for (const Command command : kCommands) {
    const OptionSet empty(command);
    for (const OptionRow* row : empty.rows()) {
      if (!row->field) continue;
      OptionSet options(command);
      const std::string value = someValue(*row);
      options.set(*row, {value});
      for (const OptionRow* other : empty.rows())
        EXPECT_EQ(spelledValue(*other, options.values()), other == row ? value : defaultOf(*other))
            << other->name << " after --" << row->name << " " << value;
    }
  }
}

TEST(OptionTable, NumbersKeepTheirLimits) {
  for (const OptionRow& row : optionTable()) {
    if (!isNumber(row)) continue;
    const OptionRange& range = row.range;
    const double step = row.type == OptionType::kInteger ? 1 : 1e-3 * std::max(1.0, std::abs(range.least));
    const auto text = [&](double value) {
      return row.type == OptionType::kInteger ? std::to_string(long(value)) : std::to_string(value);
    };
    if (std::isfinite(range.least)) {
      EXPECT_EQ(faultOf(row, text(range.least)).empty(), !range.open) << row.name;
      EXPECT_NE(faultOf(row, text(range.least - step)), "") << row.name;
      EXPECT_EQ(faultOf(row, text(range.least + step)), "") << row.name;
    }
    if (std::isfinite(range.most)) {
      EXPECT_EQ(faultOf(row, text(range.most)), "") << row.name;
      EXPECT_NE(faultOf(row, text(range.most + step)), "") << row.name;
    }
    for (const char* wrong : {"many", "", "1x", "nan", "inf", "1e999", "--"})
      EXPECT_NE(faultOf(row, wrong), "") << row.name << " " << wrong;
  }
}

TEST(OptionTable, MessagesNameOptionValueAndWhatWouldBeRight) {
  EXPECT_EQ(faultOf(morphRow("slices"), "2"), "--slices 2 is out of range; it must be 8 to 1024");
  EXPECT_EQ(faultOf(morphRow("slices"), "99999999999999999999"),
            "--slices 99999999999999999999 is out of range; it must be 8 to 1024");
  EXPECT_EQ(faultOf(morphRow("slices"), "few"), "--slices few is not a whole number; expected 8 to 1024");
  EXPECT_EQ(faultOf(morphRow("fov"), "180"), "--fov 180 is out of range; it must be 1 to 170 degrees");
  EXPECT_EQ(faultOf(morphRow("fps"), "0"), "--fps 0 must be a number above 0");
  EXPECT_EQ(faultOf(morphRow("emission"), "-1"), "--emission -1 must be 0 or more");
  EXPECT_EQ(faultOf(morphRow("spine"), "bent"), "--spine bent: expected auto, straight or curved");
  EXPECT_EQ(faultOf(morphRow("output"), ""), "-o needs a value");
}

TEST(OptionTable, HelpHasUnitRangeAndDefault) {
  EXPECT_EQ(helpOf(morphRow("slices")), "Slices per object (8 to 1024; default 96)");
  EXPECT_EQ(helpOf(morphRow("fov")), "Angle seen from bottom to top (1 to 170 degrees; default 25)");
  EXPECT_EQ(helpOf(morphRow("voxel-size")),
            "Edge of a voxel (world units, above 0; default as --resolution says)");
  EXPECT_EQ(helpOf(morphRow("ortho")), "Parallel rays, no perspective (default off)");
}

TEST(OptionSet, UnknownNamesAreErrorsOfTheProgram) {
  const OptionSet options(kInfo);
  EXPECT_THROW(options.given("frames"), std::logic_error);
  EXPECT_FALSE(options.given("spacing"));
}

TEST(OptionSet, ExclusionsAreMutual) {
  for (const Command command : kCommands) {
    const OptionSet empty(command);
    for (const OptionRow* row : empty.rows())
      for (const std::string& name : row->excludes) {
        OptionSet options(command);
        options.set(*row, {someValue(*row)});
        EXPECT_NO_THROW(options.checkExclusions()) << row->name;
        options.set(options.row(name), {someValue(options.row(name))});
        EXPECT_THROW(options.checkExclusions(), InputError) << row->name << " and " << name;
      }
  }
}

/// Frames depend on options of drawing, matching and writing, not on how the program runs.
TEST(OptionSet, FrameSettingsLeaveOutWhatFramesDoNotDependOn) {
  OptionSet options(kMorph);
  const OptionSet::Pairs before = options.frameSettings();
  for (const char* name : {"threads", "quiet", "verbose", "resume", "report", "dump-slices", "config",
                           "print-config", "check-landmarks", "range"})
    options.set(options.row(name), {someValue(options.row(name))});
  EXPECT_EQ(options.frameSettings(), before);
  options.set(options.row("samples"), {"200"});
  EXPECT_NE(options.frameSettings(), before);
  options.set(options.row("samples"), {defaultOf(options.row("samples"))});
  EXPECT_EQ(options.frameSettings(), before) << "a default that is said is the default";
}

class JobFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = (std::filesystem::temp_directory_path() / ("options_test_" + std::to_string(getpid()) + ".toml"))
                .string();
  }
  void TearDown() override { std::filesystem::remove(path_); }
  void write(const std::string& text) const { std::ofstream(path_) << text; }

  std::string path_;
};

TEST_F(JobFile, CommandLineWinsAndSilencesWhatItExcludes) {
  write("frames = 7\nresolution = 20\nslices = 50\nkeys = \"a@0 b@1\"\n");
  OptionSet options(kMorph);
  options.set(options.row("voxel-size"), {"0.5"});
  options.set(options.row("weights"), {"1,1"});
  options.set(options.row("slices"), {"60"});
  applyJobFile(path_, options);
  EXPECT_FALSE(options.given("frames"));
  EXPECT_FALSE(options.given("resolution"));
  EXPECT_FALSE(options.given("keys"));
  EXPECT_EQ(options.values().plan.slices, 60);
  EXPECT_NO_THROW(options.checkExclusions());
}

TEST_F(JobFile, ErrorsHaveTheirPlaces) {
  write("frames = 7\nat = 0.5\n");
  OptionSet options(kMorph);
  applyJobFile(path_, options);
  try {
    options.checkExclusions();
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), path_ + ":1:10: --frames and --at exclude each other; give one of them");
  }
}

/// applyJobFile() reads back every option as jobText() wrote it.
TEST_F(JobFile, EveryOptionIsReadAsItWasWritten) {
  const OptionSet empty(kMorph);
  for (const OptionRow* row : empty.rows()) {
    if (!row->field || !row->inFiles || row->type == OptionType::kTables) continue;
    OptionSet options(kMorph);
    options.set(*row, {someValue(*row)});
    write(jobText(options, {}));
    OptionSet read(kMorph);
    applyJobFile(path_, read);
    for (const OptionRow* other : empty.rows()) {
      EXPECT_EQ(read.texts(other->name), options.texts(other->name)) << other->name << " of " << row->name;
      EXPECT_EQ(spelledValue(*other, read.values()), spelledValue(*other, options.values())) << other->name;
    }
  }
}

}  // namespace
}  // namespace slicemorph
