#pragma once

#include "engine/render/picture.h"

#include <memory>
#include <string>

namespace slicemorph {

/// True for `.mp4` and `.gif`.
bool isVideoExtension(const std::string& extension);

/// An animated preview, `.mp4` (H.264, for browsers and players) or `.gif` (a palette of its own, for ever),
/// by the program ffmpeg, which takes the frames as they are made. The file appears whole or not at all.
/// Everything throws IoError naming the file.
class VideoWriter {
 public:
  /// Starts ffmpeg. Throws where it is not installed, too: the message says what can be done without it.
  VideoWriter(const std::string& path, int width, int height, double framesPerSecond);
  /// Without commit() nothing is left.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// The next frame, of the size given to the constructor.
  void add(const Picture& frame);
  void commit();

  /// Throws IoError where there is no ffmpeg, so that a long job does not find out late.
  static void checkAvailable(const std::string& path);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slicemorph
