#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <cstddef>
#include <vector>

namespace slicemorph {

/// How conjugateGradients computes with values of a type: sums in `Wide`, decisions as masks. To solve
/// several systems with the same matrix at once, a value has one lane per system; see fit_field.cpp.
template <typename Value>
struct Lanes;

template <>
struct Lanes<float> {
  using Wide = double;
  static Wide zero() { return 0; }
  static Wide wide(float v) { return v; }
  static float narrow(Wide v) { return float(v); }
  static bool any(bool mask) { return mask; }
  static bool both(bool a, bool b) { return a && b; }
  static Wide where(bool mask, Wide v) { return mask ? v : 0; }
};

/// Number of unknowns per task. Sums are taken over this many unknowns and then added in a fixed order, so
/// that the result is the same bytes for every number of threads. A sum's terms may change what belongs to their
/// unknown. (Eigen's solver accumulates single precision in single precision, with a remainder too large to stop at
/// 1e-6, and has no lanes.)
struct Grain {
  size_t size;

  template <typename Body>
  void forEach(size_t count, const Body& body) const {
    if (count <= size)
      for (size_t i = 0; i < count; ++i) body(i);
    else
      tbb::parallel_for(range(count), [&](const Range& r) {
        for (size_t i = r.begin(); i < r.end(); ++i) body(i);
      });
  }

  template <typename Wide, typename Term>
  Wide sum(size_t count, const Wide& zero, const Term& term) const {
    const auto part = [&](const Range& r, Wide total) {
      for (size_t i = r.begin(); i < r.end(); ++i) total += term(i);
      return total;
    };
    if (count <= size) return part(range(count), zero);
    return tbb::parallel_deterministic_reduce(range(count), zero, part,
                                              [](const Wide& a, const Wide& b) { return Wide(a + b); });
  }

 private:
  using Range = tbb::blocked_range<size_t>;
  Range range(size_t count) const { return {0, count, size}; }
};

/// When to stop: after this many steps, or once every lane's residual is small enough.
struct GradientSettings {
  int iterations = 60;
  double enough = 1e-6;  ///< squared residual (weighted by the preconditioner), relative to `scale`
};

/// Solves a symmetric positive definite system by conjugate gradients, preconditioned by its diagonal [HS52],
/// [She94]. The unknowns may be some of the nodes of a larger field, the rest of which is fixed.
///
/// `system` has these members:
///   size_t size() const                     number of unknowns
///   size_t node(size_t i) const             index of unknown i in the field
///   float diagonal(size_t i) const          preconditioner; 1 for none
///   Grain grain() const
///   void apply(const std::vector<Value>& field, std::vector<Value>& product)
///                                           left side, per unknown, of a field that is zero except at the
///                                           unknowns
/// `residual`: right side minus left side for the initial `field`, per unknown. `scale`: the squared residual
/// to which `settings.enough` is relative; by default the initial one. Returns the number of steps.
template <typename Value, typename System>
int conjugateGradients(System& system, const GradientSettings& settings, std::vector<Value> residual,
                       std::vector<Value>& field, const typename Lanes<Value>::Wide* scale = nullptr) {
  using L = Lanes<Value>;
  using Wide = typename L::Wide;
  const size_t n = system.size();
  const Grain grain = system.grain();
  const auto squared = [&](size_t i) {
    return Wide(L::wide(residual[i]) * L::wide(residual[i]) / double(system.diagonal(i)));
  };
  const Value zero = L::narrow(L::zero());
  std::vector<Value> direction(field.size(), zero), product(n, zero);
  grain.forEach(n, [&](size_t i) { direction[system.node(i)] = residual[i] / system.diagonal(i); });
  Wide rest = grain.sum(n, L::zero(), squared);
  const Wide enough = settings.enough * (scale ? *scale : rest);
  int step = 0;
  for (; step < settings.iterations && L::any(rest > enough); ++step) {
    system.apply(direction, product);
    const Wide bend = grain.sum(n, L::zero(), [&](size_t i) {
      return Wide(L::wide(direction[system.node(i)]) * L::wide(product[i]));
    });
    const auto goesOn = L::both(rest > enough, bend > L::zero());
    if (!L::any(goesOn)) break;
    const Value alpha = L::narrow(L::where(goesOn, rest / bend));
    const Wide next = grain.sum(n, L::zero(), [&](size_t i) {
      field[system.node(i)] += alpha * direction[system.node(i)];
      residual[i] -= alpha * product[i];
      return squared(i);
    });
    const Value beta = L::narrow(L::where(goesOn, next / rest));
    rest = next;
    grain.forEach(n, [&](size_t i) {
      direction[system.node(i)] = residual[i] / system.diagonal(i) + beta * direction[system.node(i)];
    });
  }
  return step;
}

}  // namespace slicemorph
