#include "tools/commands/command_options.h"

#include <algorithm>
#include <sstream>

namespace slicemorph {
namespace {

/// Columns of the help: where descriptions begin, and the width of the whole.
constexpr size_t kHelpColumn = 34, kHelpWidth = 118;

/// An option's names in CLI11's notation: `INPUT`, `-o,--output`, `--frames`.
std::string commandLineName(const OptionRow& row) {
  if (!row.positional.empty()) return row.positional;
  return (row.name == "output" ? "-o," : "") + ("--" + row.name);
}

/// Text with lines of at most `width` characters.
std::string wrapped(const std::string& text, size_t width) {
  std::string lines;
  size_t length = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const bool breaks = length > 0 && length + 1 + word.size() > width;
    lines += (length == 0 ? "" : breaks ? "\n" : " ") + word;
    length = (breaks || length == 0 ? 0 : length + 1) + word.size();
  }
  return lines;
}

/// The help of one command: options by the table's groups; `--help` shows the basic ones, `--help-all` all.
class GroupedHelp : public CLI::Formatter {
 public:
  explicit GroupedHelp(std::shared_ptr<const OptionSet> options) : options_(std::move(options)) {
    column_width(kHelpColumn);
  }

  const OptionSet& options() const { return *options_; }

  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    const bool all = mode != CLI::AppFormatMode::Normal;
    std::string text = make_description(app) + make_usage(app, name);
    for (int group = 0; group <= int(OptionGroup::kFarm); ++group)
      text += groupText(app, OptionGroup(group), all);
    if (all) text += methodsText();
    text += "\nHelp:\n" + make_option(app->get_help_ptr(), false);
    if (app->get_help_all_ptr()) text += make_option(app->get_help_all_ptr(), false);
    return text;
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(option->get_description(), kHelpWidth - kHelpColumn);
  }

 private:
  /// The methods of a command that has them, with their parameters.
  std::string methodsText() const {
    const auto& rows = options_->rows();
    if (std::none_of(rows.begin(), rows.end(), [](const OptionRow* row) { return row->braces; })) return "";
    std::stringstream lines;
    for (const MorphMethod& method : morphMethods())
      CLI::detail::format_help(lines, method.name, wrapped(describeMethod(method), kHelpWidth - kHelpColumn),
                               kHelpColumn);
    return "\nMethods:\n" + lines.str();
  }

  std::string groupText(const CLI::App* app, OptionGroup group, bool all) const {
    std::string text;
    for (const OptionRow* row : options_->rows())
      if (row->field && row->group == group && (all || row->basic))
        text += make_option(app->get_option(row->positional.empty() ? "--" + row->name : row->positional),
                            !row->positional.empty());
    return text.empty() ? text : "\n" + titleOf(group) + ":\n" + text;
  }

  std::shared_ptr<const OptionSet> options_;
};

CLI::Option* addOption(CLI::App& command, const OptionRow& row, const std::shared_ptr<OptionSet>& options) {
  const std::string name = commandLineName(row), help = helpOf(row);
  const OptionRow* const known = &row;
  const auto set = [options, known](const std::vector<std::string>& texts) { options->set(*known, texts); };
  if (row.type == OptionType::kFlag)
    return command.add_flag_function(
        name,
        [set](std::int64_t count) {
          if (count > 0) set({"true"});
        },
        help);
  if (row.type != OptionType::kTexts)
    return command.add_option_function<std::string>(
        name, [set](const std::string& text) { set({text}); }, help);
  CLI::Option* option = command.add_option_function<std::vector<std::string>>(name, set, help);
  return row.positional.empty() ? option->allow_extra_args(false) : option;
}

}  // namespace

std::shared_ptr<OptionSet> addOptions(CLI::App& command, Command which) {
  const auto options = std::make_shared<OptionSet>(which);
  for (const OptionRow* row : options->rows()) {
    if (!row->field) continue;
    CLI::Option* option = addOption(command, *row, options);
    option->group(titleOf(row->group))->required(row->required);
    if (row->type != OptionType::kFlag) option->type_name(formOf(*row));
  }
  command.formatter(std::make_shared<GroupedHelp>(options));
  return options;
}

const OptionSet& optionsOf(const CLI::App& command) {
  return dynamic_cast<const GroupedHelp&>(*command.get_formatter()).options();
}

}  // namespace slicemorph
