#pragma once

namespace slicemorph {

/// Progress sink and cancel token of long work; the default does nothing. Calls may come from any thread.
class Progress {
 public:
  virtual ~Progress() = default;
  /// `stage`: a short verb phrase; `fraction`: of the whole job, 0 to 1.
  virtual void report(const char* stage, double fraction) { (void)stage, (void)fraction; }
  virtual bool cancelled() const { return false; }
};

}  // namespace slicemorph
