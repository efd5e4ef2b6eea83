#pragma once

namespace slicemorph {

/// Progress sink and cancel token for long work; by default it does nothing. Methods may be called
/// from any thread.
class Progress {
 public:
  virtual ~Progress() = default;
  /// `stage`: a short verb phrase; `fraction`: of the whole job, 0 to 1.
  virtual void report(const char* stage, double fraction) { (void)stage, (void)fraction; }
  virtual bool cancelled() const { return false; }
};

}  // namespace slicemorph
