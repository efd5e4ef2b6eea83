#pragma once

#include "tools/job/morph_settings.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>

namespace slicemorph {

/// The options of `slicemorph morph` as typed.
class MorphOptionSet {
 public:
  explicit MorphOptionSet(CLI::App& command);
  /// Reads the job file, if one is given, and checks everything that can be checked without reading the
  /// inputs. With --print-config it prints a job file instead and throws CLI::Success, as CLI11 itself does
  /// for --help. Throws InputError, IoError.
  MorphSettings settings();

 private:
  struct Values;
  MorphSettings checked();
  void setTimes(MorphSettings& settings);
  void setWeights(MorphSettings& settings);
  void setGuidance(MorphSettings& settings);
  bool said(const std::string& key) const;
  std::shared_ptr<Values> values_;
};

}  // namespace slicemorph
