#include "io/image/video_writer.h"

#include "io/atomic_file.h"
#include "io/image/display_pixels.h"
#include "io/paths.h"
#include "io/scratch_folder.h"
#include "slicemorph/errors.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

extern char** environ;

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// Path of a program in the folders of PATH; empty where there is none.
std::string findProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string program = (folder.empty() ? "." : folder) + "/" + name;
    std::error_code ignored;
    if (fs::is_regular_file(program, ignored) && ::access(program.c_str(), X_OK) == 0) return program;
  }
  return "";
}

std::string textOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// ffmpeg's command line. One thread and "bitexact", so that the same ffmpeg gives the same bytes
/// on every machine.
std::vector<std::string> argumentsFor(const std::string& from, const std::string& to, int width, int height,
                                      double framesPerSecond) {
  char rate[32];
  std::snprintf(rate, sizeof rate, "%.6g", framesPerSecond);
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  std::vector<std::string> words = {from};
  const auto add = [&](const std::string& options) {
    std::istringstream stream(options);
    for (std::string word; stream >> word;) words.push_back(word);
  };
  add("-nostdin -loglevel error -y -f rawvideo -pix_fmt rgb24 -video_size " + size + " -framerate " + rate +
      " -i pipe:0 -threads 1 -map_metadata -1 -fflags +bitexact -flags:v +bitexact");
  if (extensionOf(to) == ".gif") {
    add("-filter_complex split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=sierra2_4a "
        "-loop 0");
  } else {
    // Many players need even sides and 4:2:0 chroma. Colour space and range are tagged, so that players do
    // not guess. CRF 18 is commonly taken as visually lossless.
    add("-vf pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv "
        "-c:v libx264 -crf 18 -pix_fmt yuv420p -colorspace bt709 -color_primaries bt709 "
        "-color_trc iec61966-2-1 -color_range tv -movflags +faststart");
  }
  words.push_back(to);
  return words;
}

}  // namespace

bool isVideoExtension(const std::string& extension) { return extension == ".mp4" || extension == ".gif"; }

void VideoWriter::checkAvailable(const std::string& path) {
  if (findProgram("ffmpeg").empty())
    throw IoError(path,
                  "cannot be written: the program ffmpeg is not installed (none in PATH); install it, or "
                  "write frames, " +
                      fs::path(path).replace_extension().string() + ".####.png");
}

struct VideoWriter::Impl {
  std::string path;
  int width, height;
  ScratchFolder scratch = {};
  std::string made = scratch.file("made" + extensionOf(path)), said = scratch.file("said");
  int socket = -1;
  pid_t program = -1;

  void start(double framesPerSecond) {
    checkAvailable(path);
    // A socket instead of a pipe: when ffmpeg exits, send() fails without a SIGPIPE that would
    // end this program.
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw IoError(path, std::string("cannot be written: ") + std::strerror(errno));
    socket = ends[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, said.c_str(), O_WRONLY | O_CREAT, 0600);
    std::vector<std::string> words =
        argumentsFor(findProgram("ffmpeg"), made, width, height, framesPerSecond);
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int failed = ::posix_spawn(&program, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (failed) {
      program = -1;
      throw IoError(path,
                    std::string("cannot be written: ffmpeg cannot be started: ") + std::strerror(failed));
    }
  }

  /// Closes ffmpeg's input and waits for its exit. Returns whether it succeeded.
  bool finish() {
    if (socket >= 0) ::close(socket);
    socket = -1;
    int status = 0;
    while (program > 0 && ::waitpid(program, &status, 0) < 0 && errno == EINTR) {
    }
    program = -1;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

  [[noreturn]] void fail() {
    finish();
    std::string reason = textOf(said);
    while (!reason.empty() && reason.back() == '\n') reason.pop_back();
    throw IoError(path, "cannot be written: ffmpeg gave up" + (reason.empty() ? "" : ": " + reason));
  }

  ~Impl() {
    if (program > 0) ::kill(program, SIGKILL);
    finish();
  }
};

VideoWriter::VideoWriter(const std::string& path, int width, int height, double framesPerSecond)
    : impl_(new Impl{path, width, height}) {
  impl_->start(framesPerSecond);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::add(const Picture& frame) {
  const std::vector<std::uint8_t> pixels = displayPixels(frame, /*alpha=*/false);
  for (size_t done = 0; done < pixels.size();) {
    const ssize_t sent = ::send(impl_->socket, pixels.data() + done, pixels.size() - done, MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR) impl_->fail();
    if (sent > 0) done += size_t(sent);
  }
}

void VideoWriter::commit() {
  if (!impl_->finish()) impl_->fail();
  AtomicFile output(impl_->path);
  output.write(textOf(impl_->made));
  output.commit();
}

}  // namespace slicemorph
