#pragma once

#include "engine/render/picture.h"

#include <memory>
#include <string>

namespace slicemorph {

/// True for `.mp4` and `.gif`.
bool isVideoExtension(const std::string& extension);

/// An animated preview, `.mp4` (H.264) or `.gif` (with a palette of its own, looping for ever), encoded by
/// the program ffmpeg, to which frames are sent as they are added. The file appears whole or not at all.
/// Everything throws IoError naming the file.
class VideoWriter {
 public:
  /// Starts ffmpeg. Also throws where it is not installed; the message says what can be done without it.
  VideoWriter(const std::string& path, int width, int height, double framesPerSecond);
  /// Without a commit() before no file is left.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// The next frame, of the size given to the constructor.
  void add(const Picture& frame);
  void commit();

  /// Throws IoError where there is no ffmpeg; to be called before long work is done.
  static void checkAvailable(const std::string& path);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slicemorph
