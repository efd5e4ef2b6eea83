#pragma once

#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// How important a note is to its reader.
enum class Severity {
  kDetail,   ///< how a decision was reached; for reports and --verbose
  kNote,     ///< what was found, chosen or changed: worth knowing
  kWarning,  ///< what is probably wrong, and what can be done about it
  kError,    ///< what could not be done; the note of an exception
};

/// Something that was found, decided or changed. Code that reacts to a note must use its code,
/// never its text.
struct Note {
  Note() = default;
  explicit Note(std::string text) : text(std::move(text)) {}
  Note(std::string code, Severity severity, std::string about, std::string text)
      : code(std::move(code)), severity(severity), about(std::move(about)), text(std::move(text)) {}

  std::string code;  ///< stable, prefixed by the stage: "mesh.holes-closed", "frame.turned"
  Severity severity = Severity::kNote;
  std::string about;  ///< the file, grid, option or object; empty: the whole job
  std::string text;   ///< one sentence, without the name of its subject in front and without a full stop

  /// The text as shown to people: "about: text".
  std::string sentence() const { return about.empty() ? text : about + ": " + text; }
};

using Notes = std::vector<Note>;

inline std::vector<std::string> sentencesOf(const Notes& notes) {
  std::vector<std::string> sentences;
  for (const Note& note : notes) sentences.push_back(note.sentence());
  return sentences;
}

/// The same notes, with `subject` in front of what they are about: for a grid of a file, an output
/// of a frame.
inline Notes about(const std::string& subject, Notes notes) {
  for (Note& note : notes) note.about = note.about.empty() ? subject : subject + ": " + note.about;
  return notes;
}

}  // namespace slicemorph
