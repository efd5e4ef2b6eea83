#pragma once

#include "tools/job/job_options.h"
#include "tools/job/methods.h"

#include <limits>
#include <string>
#include <variant>
#include <vector>

/// One option of the program as data: see option_table.h.
namespace slicemorph {

/// kNumbers: numbers separated by commas, or another text; in a file also a list or one number. kLandmarks:
/// names of files, or landmarks, `x,y,z=x,y,z;...`. kTables: a text on the command line, tables in a file,
/// which guidance_file.h reads.
enum class OptionType { kFlag, kInteger, kNumber, kText, kTexts, kNumbers, kLandmarks, kTables };

/// In the order of the help.
enum class OptionGroup { kInputs, kShape, kMatching, kOutputs, kImages, kPictures, kFarm };

/// Commands are bits, since a row may belong to several.
enum Command : unsigned {
  kMorph = 1,
  kSlice = 2,
  kReconstruct = 4,
  kConvert = 8,
  kRender = 16,
  kCompare = 32,
  kInfo = 64,
  kApply = 128,
  kRetime = 256,
  kPick = 512,
  kDemo = 1024,
  kSurvey = 2048,
};

/// The field that a row is bound to; none for tables that only files have.
using OptionField =
    std::variant<std::monostate, bool*, int*, double*, std::string*, std::vector<std::string>*>;

/// Limits of a number.
struct OptionRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool open = false;  ///< `least` itself is out of range
};

/// The kind of output of `morph` for which an option has an effect.
enum class OptionTarget { kAny, kPictures, kExrSlices };

struct OptionRow {
  std::string name;        ///< as in `--name` and in job files
  std::string positional;  ///< its name in the help; empty: the option has dashes
  OptionType type = OptionType::kText;
  OptionGroup group = OptionGroup::kOutputs;
  unsigned commands = 0;
  OptionField (*field)(JobOptions&) = nullptr;
  std::string form;  ///< what a value looks like: `N`, `X,Y,Z`
  std::string unit;  ///< of numbers: "degrees"; empty: none
  OptionRange range;
  std::vector<std::string> choices;  ///< empty: any text
  bool braces = false;               ///< behind a choice may stand its parameters: `levelset{steps=500}`
  std::string help;                  ///< what it does; unit, range and default are added by helpOf()
  std::string fallback;              ///< the default in words, if the field's initial value does not state it
  std::vector<std::string> excludes;    ///< options that cannot be given together with this one
  std::vector<std::string> silencedBy;  ///< more options that on the command line overrule a file's value
  bool MethodTraits::*needs = nullptr;  ///< what the method of `morph` must be able to do; null: nothing
  OptionTarget target = OptionTarget::kAny;
  bool basic = false;     ///< in the short help
  bool required = false;  ///< the command needs it
  bool inFiles = true;    ///< job files may have it
  bool inFrames = true;   ///< frames depend on it, so --resume compares it

  bool isOf(Command command) const { return (commands & command) != 0; }
};

/// The heading of a group in the help: "Matching".
std::string titleOf(OptionGroup group);
/// An option's name for messages: `--name`, or `-o`, `INPUT` where that is what users type.
std::string spelledName(const OptionRow& row);
/// What a value looks like, choices joined by bars; empty for flags.
std::string formOf(const OptionRow& row);
/// The help with unit, range and default: "Slices per object (8 to 1024; default 96)".
std::string helpOf(const OptionRow& row);
/// The default as a value; empty where there is none, or it is found later from the inputs.
std::string defaultOf(const OptionRow& row);
/// A field's value as the command line would spell it; empty for false, and for a 0 that means "not given",
/// in options with a fallback.
std::string spelledValue(const OptionRow& row, const JobOptions& options);

/// Checks type, range and choices of a value and puts it into the row's field. Throws InputError naming the
/// option, the value and what would be right.
void setField(const OptionRow& row, const std::vector<std::string>& texts, JobOptions& options);

}  // namespace slicemorph
