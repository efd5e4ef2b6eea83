#include "tools/commands/manual.h"

#include "io/atomic_file.h"
#include "slicemorph/errors.h"
#include "tools/commands/command_options.h"

#include <cctype>
#include <filesystem>
#include <sstream>
#include <vector>

namespace slicemorph {
namespace {

/// Text as man pages spell it: no dash becomes a hyphen, no line a request.
std::string roff(const std::string& text) {
  std::string result;
  bool begins = true;
  for (const char c : text) {
    if (begins && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
    begins = c == '\n';
  }
  return result;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }

std::string section(const std::string& title) { return ".SH " + title + "\n"; }

/// A paragraph of a word and what it means.
std::string entry(const std::string& term, const std::string& meaning) {
  return ".TP\n" + term + "\n" + roff(meaning) + "\n";
}

std::string upper(std::string text) {
  for (char& c : text) c = char(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string head(const std::string& name, const std::string& purpose) {
  return ".TH " + roff(upper(name)) + " 1 \"\" \"slicemorph " SLICEMORPH_VERSION "\" \"User Commands\"\n" +
         section("NAME") + roff(name) + " \\- " + roff(purpose) + "\n";
}

std::string foot(const std::string& seeAlso) {
  return section("EXIT STATUS") + entry("0", "Done.") +
         entry("1", "Failed: the message on standard error says why.") +
         entry("2", "Wrong usage: an option or an input that cannot be right.") + section("ENVIRONMENT") +
         entry(bold("SLICEMORPH_PLUGINS"),
               "Folder of the plug-ins, where they are not in their place of installation.") +
         entry(bold("SOURCE_DATE_EPOCH"),
               "Seconds since 1970, the date that DICOM files get; without it, today's.") +
         section("SEE ALSO") + seeAlso;
}

/// An option as it is typed, its value in italics: "-o, --output OUTPUT".
std::string typed(const OptionRow& row) {
  if (!row.positional.empty()) return "\\fI" + roff(row.positional) + "\\fR";
  const std::string form = formOf(row);
  return (row.name == "output" ? bold("-o") + ", " : "") + bold("--" + row.name) +
         (form.empty() ? "" : " \\fI" + roff(form) + "\\fR");
}

/// The methods with their parameters, of a command that has them.
std::string methodsOf(const OptionSet& options) {
  std::string entries;
  for (const OptionRow* row : options.rows())
    if (row->braces)
      for (const MorphMethod& method : morphMethods())
        entries += entry(bold(method.name), describeMethod(method) + ".");
  return entries.empty() ? "" : section("METHODS") + entries;
}

std::string pageOf(const CLI::App& command) {
  const std::string name = "slicemorph-" + command.get_name();
  const OptionSet& options = optionsOf(command);
  std::string synopsis, groups;
  for (int group = 0; group <= int(OptionGroup::kFarm); ++group) {
    std::string entries;
    for (const OptionRow* row : options.rows())
      if (row->field && int(row->group) == group) entries += entry(typed(*row), helpOf(*row));
    if (!entries.empty()) groups += ".SS " + titleOf(OptionGroup(group)) + "\n" + entries;
  }
  for (const OptionRow* row : options.rows())
    if (row->field && !row->positional.empty())
      synopsis += " " + typed(*row) + (row->type == OptionType::kTexts ? "..." : "");
  return head(name, command.get_description()) + section("SYNOPSIS") +
         bold("slicemorph " + command.get_name()) + " [\\fIOPTIONS\\fR]" + synopsis + "\n" +
         section("OPTIONS") + groups + ".SS Help\n" +
         entry(bold("--help"), "Print the most used options and exit.") +
         entry(bold("--help-all"), "Print every option and exit.") + methodsOf(options) +
         foot(".BR slicemorph (1)\n");
}

std::string mainPage(const CLI::App& program, const std::vector<const CLI::App*>& commands) {
  std::string list, seeAlso;
  for (const CLI::App* command : commands) {
    list += entry(bold("slicemorph-" + command->get_name()) + "(1)", command->get_description());
    seeAlso +=
        std::string(seeAlso.empty() ? "" : " ,\n") + ".BR slicemorph\\-" + command->get_name() + " (1)";
  }
  const std::string purpose = program.get_description().substr(0, program.get_description().find(".\n"));
  return head("slicemorph", purpose) + section("SYNOPSIS") + bold("slicemorph") +
         " \\fICOMMAND\\fR [\\fIOPTIONS\\fR] ...\n" + section("DESCRIPTION") +
         roff(
             "Turns one volume into another, or blends several: level sets and smoke of OpenVDB, meshes, "
             "scans and label "
             "maps. Each is cut into oriented slices, contours are traced on them, matched and interpolated, "
             "and the volume is "
             "built anew.\n") +
         section("COMMANDS") + list + section("OPTIONS") +
         entry(bold("--help"), "Print the commands and exit.") +
         entry(bold("--help-all"), "Print every option of every command and exit.") +
         entry(bold("--version"), "Print the version and exit.") +
         entry(bold("--manual") + " \\fIFOLDER\\fR",
               "Write these pages and the completion for bash, and exit.") +
         section("EXAMPLES") + ".EX\n" +
         roff(
             "slicemorph morph cat.obj lion.obj -o morph.####.vdb --frames 24\n"
             "slicemorph retime smoke.####.vdb -o slow.####.vdb --factor 4\n"
             "slicemorph reconstruct labels.nii.gz -o dense.nii.gz\n") +
         ".EE\n" + foot(seeAlso + "\n");
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// A function that proposes commands, options and their choices; where it proposes nothing, bash proposes files.
std::string completion(const std::vector<const CLI::App*>& commands) {
  std::vector<std::string> names;
  std::ostringstream options, choices;
  for (const CLI::App* command : commands) {
    names.push_back(command->get_name());
    std::vector<std::string> words{"--help", "--help-all"};
    for (const OptionRow* row : optionsOf(*command).rows()) {
      if (!row->field || !row->positional.empty()) continue;
      words.push_back("--" + row->name);
      if (!row->choices.empty())
        choices << "    '" << command->get_name() << " --" << row->name << "') words='"
                << joined(row->choices) << "' ;;\n";
    }
    options << "      " << command->get_name() << ") words='" << joined(words) << "' ;;\n";
  }
  return "# bash completion for slicemorph\n"
         "_slicemorph() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=\n"
         "  COMPREPLY=()\n"
         "  if [ \"$COMP_CWORD\" = 1 ]; then\n"
         "    COMPREPLY=($(compgen -W '" +
         joined(names) +
         " --help --help-all --version' -- \"$current\"))\n"
         "    return\n"
         "  fi\n"
         "  case \"${COMP_WORDS[1]} $before\" in\n" +
         choices.str() +
         "  esac\n"
         "  case \"$current\" in\n"
         "    -*) case \"${COMP_WORDS[1]}\" in\n" +
         options.str() +
         "    esac ;;\n"
         "  esac\n"
         "  if [ -n \"$words\" ]; then COMPREPLY=($(compgen -W \"$words\" -- \"$current\")); fi\n"
         "}\n"
         "complete -o default -F _slicemorph slicemorph\n";
}

}  // namespace

void writeManual(const CLI::App& program, const std::string& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) throw IoError(folder, "the folder cannot be made: " + problem.message());
  std::vector<const CLI::App*> commands;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command);
  const auto write = [&](const std::string& name, const std::string& text) {
    writeTextFile(folder + "/" + name, text);
  };
  write("slicemorph.1", mainPage(program, commands));
  for (const CLI::App* command : commands)
    write("slicemorph-" + command->get_name() + ".1", pageOf(*command));
  write("slicemorph.bash", completion(commands));
}

}  // namespace slicemorph
