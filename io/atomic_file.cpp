#include "io/atomic_file.h"

#include "slicemorph/errors.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <streambuf>
#include <vector>

namespace slicemorph {
namespace {

constexpr size_t kBuffer = 1 << 20;  // bytes gathered before the system is called

std::filesystem::path folderOf(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  return folder.empty() ? std::filesystem::path(".") : folder;
}

std::string temporaryFor(const std::string& path, long process) {
  const std::string name =
      "." + std::filesystem::path(path).filename().string() + ".tmp-" + std::to_string(process);
  return (folderOf(path) / name).string();
}

/// Flushes the folder, so that the renaming survives a crash. Failures are ignored: the file
/// itself is complete.
void flushFolder(const std::string& path) {
  const int folder = ::open(folderOf(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::fsync(folder);
  ::close(folder);
}

std::mutex openFilesLock;
AtomicFile* anOpenFile = nullptr;  ///< one of the files that are being written; the others hang on it

}  // namespace

void AtomicFile::list() {
  const std::lock_guard<std::mutex> lock(openFilesLock);
  after_ = anOpenFile;
  if (anOpenFile) anOpenFile->before_ = this;
  anOpenFile = this;
}

void AtomicFile::unlist() noexcept {
  const std::lock_guard<std::mutex> lock(openFilesLock);
  (before_ ? before_->after_ : anOpenFile) = after_;
  if (after_) after_->before_ = before_;
  before_ = after_ = nullptr;
}

void removeOpenFiles() noexcept {
  // Not waited for: whoever holds it may be the one that cannot go on.
  const std::unique_lock<std::mutex> lock(openFilesLock, std::try_to_lock);
  if (!lock) return;
  for (const AtomicFile* file = anOpenFile; file; file = file->after_) ::unlink(file->temporary_.c_str());
}

/// The buffer of stream(): writes into the file and fails as write() does.
class AtomicFile::StreamBuffer : public std::streambuf {
 public:
  explicit StreamBuffer(AtomicFile& file) : file_(file), bytes_(kBuffer) { reset(); }

 protected:
  int_type overflow(int_type c) override {
    drain();
    if (c != traits_type::eof()) *pptr() = char(c), pbump(1);
    return traits_type::not_eof(c);
  }
  int sync() override {
    drain();
    return 0;
  }
  pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode) override {
    drain();
    const int whence = from == std::ios::beg ? SEEK_SET : from == std::ios::cur ? SEEK_CUR : SEEK_END;
    return pos_type(::lseek(file_.descriptor_, off_t(offset), whence));
  }
  pos_type seekpos(pos_type to, std::ios::openmode mode) override {
    return seekoff(off_type(to), std::ios::beg, mode);
  }

 private:
  void drain() {
    file_.writeThrough({pbase(), size_t(pptr() - pbase())});
    reset();
  }
  void reset() { setp(bytes_.data(), bytes_.data() + bytes_.size()); }

  AtomicFile& file_;
  std::vector<char> bytes_;
};

AtomicFile::AtomicFile(const std::string& path) : path_(path), temporary_(temporaryFor(path, ::getpid())) {
  descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot be created");
  list();
  try {
    buffer_.reserve(kBuffer);
  } catch (...) {
    discard();  // no destructor follows
    throw;
  }
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBuffer) {
    writeThrough(buffer_);
    buffer_.clear();
  }
  if (bytes.size() >= kBuffer) {
    writeThrough(bytes);
  } else {
    buffer_.append(bytes);
  }
}

std::ostream& AtomicFile::stream() {
  if (!stream_) {
    streamBuffer_ = std::make_unique<StreamBuffer>(*this);
    stream_ = std::make_unique<std::ostream>(streamBuffer_.get());
    stream_->exceptions(std::ios::failbit | std::ios::badbit);
  }
  return *stream_;
}

void AtomicFile::read(std::uint64_t offset, const std::function<void(std::string_view)>& part) {
  std::string bytes(kBuffer, '\0');
  while (true) {
    const ssize_t count = ::pread(descriptor_, bytes.data(), bytes.size(), off_t(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("cannot be read back");
    if (count == 0) return;
    part(std::string_view(bytes).substr(0, size_t(count)));
    offset += std::uint64_t(count);
  }
}

void AtomicFile::overwrite(std::uint64_t offset, std::string_view bytes) {
  writeThrough(buffer_);
  buffer_.clear();
  if (::pwrite(descriptor_, bytes.data(), bytes.size(), off_t(offset)) != ssize_t(bytes.size()))
    fail("cannot be written");
}

void AtomicFile::commit() {
  stream_.reset();
  writeThrough(buffer_);
  buffer_.clear();
  // Some file systems report a full disk only here; EINVAL: not a file that can be flushed.
  if (::fsync(descriptor_) != 0 && errno != EINVAL) fail("cannot be written");
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  unlist();
  if (closed != 0 || std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    const int reason = errno;
    ::unlink(temporary_.c_str());
    errno = reason;
    fail("cannot be written");
  }
  flushFolder(path_);
}

void AtomicFile::writeThrough(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail("cannot be written");
    bytes.remove_prefix(size_t(done));
  }
}

void AtomicFile::discard() noexcept {
  if (descriptor_ < 0) return;
  unlist();
  ::close(descriptor_);
  ::unlink(temporary_.c_str());
  descriptor_ = -1;
}

void AtomicFile::fail(const char* what) {
  // Writers that end by writing the rest fail again: the first reason counts.
  if (failure_.empty()) failure_ = std::string(what) + ": " + std::strerror(errno);
  discard();
  throw IoError(path_, failure_);
}

void removeUnfinished(const std::string& path, long process) noexcept {
  ::unlink(temporaryFor(path, process).c_str());
}

void writeTextFile(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace slicemorph
