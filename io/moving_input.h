#pragma once

#include "slicemorph/io/input.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// The files of an input in the order of its frames; of an input that does not move the one. All files of a sequence
/// are read by one grid, that of the first file that holds something, and files that hold nothing, before what is
/// there begins or after it ended, are told from files that are no shape.
class MovingInput {
 public:
  /// Throws IoError where there is no file of a sequence.
  explicit MovingInput(const InputSpec& input);

  bool moves() const { return moves_; }
  size_t size() const { return files_.size(); }
  /// The file of a frame, from 0; the last one when the sequence is over.
  const InputSpec& file(size_t frame) const { return files_[std::min(frame, files_.size() - 1)]; }
  /// Numbers that are missing.
  Notes notes() const;

  /// Loads the file of a frame; of one that holds nothing asNothing() beside the nearest one before it, else after it,
  /// that holds something. Throws as loadObject; NothingError where no file holds anything.
  LoadedObject load(size_t frame, const LoadOptions& options);

 private:
  /// The object of the n-th file; none where it holds nothing.
  std::optional<LoadedObject> tried(size_t n, const LoadOptions& options);
  /// Of a sequence of VDB files of which no grid is named.
  void chooseGrid(const LoadOptions& options);
  [[noreturn]] void refuseAsNothing(const LoadOptions& options) const;
  const LoadedObject& pieceFor(size_t n, const LoadOptions& options);

  InputSpec input_;
  bool moves_ = false;
  std::vector<InputSpec> files_;
  std::vector<int> missing_;
  bool chosen_ = false;     ///< the grid is
  std::string grid_;        ///< name of the grid where the input names none; empty: no VDB
  std::vector<char> full_;  ///< per file: unknown (0), holds nothing (1), something (2)
  std::optional<LoadedObject> piece_;
  size_t pieceAt_ = 0;  ///< the file of piece_
};

}  // namespace slicemorph
