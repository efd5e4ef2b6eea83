#pragma once

#include "tools/job/job_events.h"
#include "tools/job/option_set.h"

#include <map>
#include <string>
#include <vector>

/// Command-line modules of 3D Slicer as data. From it come the description that Slicer builds its panel of (module_xml.h)
/// and the reading of the command line that Slicer builds of that (module_values.h).
namespace slicemorph {

/// What a value is, and so which element describes it. Objects of the scene (volumes, label maps, models) go
/// through files that Slicer writes and reads, a list of control points is given point by point; a remark is what a module
/// answers.
enum class ParameterKind {
  kVolume,
  kLabelMap,
  kModel,
  kFile,
  kFolder,
  kPoints,
  kFlag,
  kInteger,
  kNumber,
  kText,
  kChoice,
  kRemark
};

struct ModuleParameter {
  ParameterKind kind = ParameterKind::kText;
  std::string name;  ///< in the XML and after two dashes; Slicer allows only letters, digits and underscores
  std::string label, help;
  bool output = false;
  std::vector<std::string> extensions;  ///< of files; Slicer takes the first for those that it makes up
  std::string beside;                   ///< of outputs: the input beside which it stands in the scene
  std::string value;  ///< the default; of numbers there must be one, as Slicer gives them always
  OptionRange range;
  double step = 1;
  std::vector<std::string> choices;
  std::string
      option;  ///< the option of the program that gets the value, unless it is the default; empty: none
};

struct ParameterGroup {
  std::string label, help;
  bool advanced = false;  ///< folded at first
  std::vector<ModuleParameter> parameters;
};

/// The values of a module's parameters.
class ModuleValues {
 public:
  explicit ModuleValues(const std::vector<ParameterGroup>& groups);

  const ModuleParameter& parameter(const std::string& name) const;
  /// Takes a value, of a list of points one more. Throws InputError for a number that is none, or out of range.
  void set(const std::string& name, const std::string& text);
  /// The value, or the default; points as `x,y,z;x,y,z`. Names that the module does not have throw std::logic_error.
  const std::string& text(const std::string& name) const;
  double number(const std::string& name) const;
  /// Whether there is a value that is not the default.
  bool given(const std::string& name) const;
  /// Gives all values that are given to the options that they belong to. Throws InputError.
  void apply(OptionSet& options) const;

 private:
  std::map<std::string, ModuleParameter> parameters_;
  std::map<std::string, std::string> texts_;
};

struct SlicerModule {
  std::string name, title, description;
  std::vector<ParameterGroup> groups;
  void (*run)(const ModuleValues& values, JobEvents& events) = nullptr;
};

/// A parameter that is an option of the program: type, help, range, choices and default are the option's. Where the
/// default of a number is found by the program it is 0.
ModuleParameter ofOption(Command command, const std::string& option);
/// Its name as a parameter: `voxelSize` of `voxel-size`.
std::string parameterName(const std::string& option);

/// An object of the scene, by its kind's usual files.
ModuleParameter inputOf(ParameterKind kind, const std::string& name, const std::string& label,
                        const std::string& help);
ModuleParameter outputOf(ParameterKind kind, const std::string& name, const std::string& label,
                         const std::string& help, const std::string& beside);
/// Folders are no sign that files are wanted: Slicer fills them in by itself.
ModuleParameter folderOf(const std::string& name, const std::string& label, const std::string& help);

/// What all modules have: threads, memory, and the remarks that they answer.
ParameterGroup executionGroup(Command command);

SlicerModule morphModule();
SlicerModule fillModule();
SlicerModule surfaceModule();

}  // namespace slicemorph
