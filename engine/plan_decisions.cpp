#include "engine/plan_decisions.h"

#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <cstdint>
#include <cstring>
#include <type_traits>

namespace slicemorph {

namespace {

/// Begins the bytes; the number is raised whenever what follows changes.
const std::string kMark = "slicemorph decisions 2\n";

class DecisionWriter {
 public:
  template <typename Number>
  void add(const Number& value) {
    static_assert(std::is_arithmetic<Number>::value, "numbers only");
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void addCount(size_t count) { add(std::uint64_t(count)); }
  void add(const std::string& text) { addCount(text.size()), bytes_ += text; }
  void addRaw(const std::string& bytes) { bytes_ += bytes; }
  void add(const Vec3d& v) {
    for (int c = 0; c < 3; ++c) add(v[c]);
  }
  void add(const Mat3d& m) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) add(m(r, c));
  }
  void add(const Notes& notes) {
    addCount(notes.size());
    for (const Note& note : notes)
      add(note.code), add(std::int32_t(note.severity)), add(note.about), add(note.text);
  }
  std::string bytes() && { return std::move(bytes_); }

 private:
  std::string bytes_ = kMark;
};

[[noreturn]] void refuseDecisions() {
  throw InputError("the plan is damaged or was made by another version; make it anew");
}

class DecisionReader {
 public:
  explicit DecisionReader(const std::string& bytes) : bytes_(bytes) {
    if (bytes_.compare(0, kMark.size(), kMark) != 0) refuseDecisions();
  }
  template <typename Number>
  Number number() {
    Number value;
    if (bytes_.size() - at_ < sizeof value) refuseDecisions();
    std::memcpy(&value, &bytes_[at_], sizeof value);
    at_ += sizeof value;
    return value;
  }
  /// Of things that take at least `each` bytes.
  size_t count(size_t each) {
    const std::uint64_t count = number<std::uint64_t>();
    if (count > (bytes_.size() - at_) / each) refuseDecisions();
    return size_t(count);
  }
  std::string text() { return raw(count(1)); }
  std::string raw(size_t size) {
    if (!holds(size)) refuseDecisions();
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  Vec3d vector() {
    Vec3d v;
    for (int c = 0; c < 3; ++c) v[c] = number<double>();
    return v;
  }
  Mat3d matrix() {
    Mat3d m;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) m(r, c) = number<double>();
    return m;
  }
  Notes notes() {
    Notes notes(count(1));
    for (Note& note : notes) {
      note.code = text(), note.severity = Severity(number<std::int32_t>());
      note.about = text(), note.text = text();
    }
    return notes;
  }
  bool holds(size_t bytes) const { return bytes_.size() - at_ >= bytes; }
  bool atEnd() const { return at_ == bytes_.size(); }

 private:
  const std::string& bytes_;
  size_t at_ = kMark.size();
};

/// FNV-1a of a level set's active voxels and transform.
std::uint64_t checksumOf(const FloatGrid& grid) {
  std::uint64_t hash = 14695981039346656037ull;
  const auto mix = [&](const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211ull;
  };
  const openvdb::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
  mix(matrix.asPointer(), 16 * sizeof(double));
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    mix(leaf->origin().asPointer(), 3 * sizeof(int));
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      const openvdb::Index position = value.pos();
      const float distance = *value;
      mix(&position, sizeof position), mix(&distance, sizeof distance);
    }
  }
  return hash;
}

void addChart(DecisionWriter& writer, const Chart& chart) {
  writer.add(chart.center), writer.add(chart.axes), writer.add(chart.scale);
  writer.add(std::uint8_t(!chart.bend.straight()));
  if (chart.bend.straight()) return;
  writer.add(chart.bend.half());
  for (const Vec3d& rate : chart.bend.rates()) writer.add(rate);
}

Chart chartFrom(DecisionReader& reader) {
  Chart chart;
  chart.center = reader.vector(), chart.axes = reader.matrix(), chart.scale = reader.vector();
  if (!reader.number<std::uint8_t>()) return chart;
  const double half = reader.number<double>();
  std::vector<Vec3d> rates(Bend::kStations);
  for (Vec3d& rate : rates) rate = reader.vector();
  chart.bend = Bend(half, std::move(rates));
  return chart;
}

/// A float's bits as a number that grows with it, so that floats next to each other differ by little.
std::uint32_t orderOf(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

float ofOrder(std::uint32_t order) {
  const std::uint32_t bits = order & 0x80000000u ? order & 0x7fffffffu : ~order;
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// What the neighbours before a node say of its value where a field is smooth: the Lorenzo predictor [ILRS03].
float predicted(const Lattice& lattice, const std::vector<float>& value, int x, int y, int z) {
  const auto at = [&](int dx, int dy, int dz) {
    return x < dx || y < dy || z < dz ? 0.f : value[lattice.index(x - dx, y - dy, z - dz)];
  };
  return at(1, 0, 0) + at(0, 1, 0) + at(0, 0, 1) - at(1, 1, 0) - at(1, 0, 1) - at(0, 1, 1) + at(1, 1, 1);
}

/// Calls visit(node, x, y, z) for every node, in an order in which the neighbours that predict it come first.
template <typename Visit>
void visitInOrder(const Lattice& lattice, const Visit& visit) {
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) visit(lattice.index(x, y, z), x, y, z);
}

/// The field's numbers as differences to what is predicted, small ones near 0, byte by byte: the first bytes of all,
/// then the second ones ..., as this is what a compressor makes small. `about`: a field that it is like.
void addField(DecisionWriter& writer, const Lattice& lattice, const VectorField& field,
              const VectorField& about) {
  const size_t count = lattice.count();
  std::string bytes(3 * 4 * count, '\0');
  tbb::parallel_for(0, 3, [&](int c) {
    std::vector<float> off(count);
    char* const first = &bytes[size_t(c) * 4 * count];
    visitInOrder(lattice, [&](size_t node, int x, int y, int z) {
      const float expected = about[node][c] + predicted(lattice, off, x, y, z);
      off[node] = field[node][c] - about[node][c];
      const std::uint32_t difference = orderOf(field[node][c]) - orderOf(expected);
      const std::uint32_t folded = difference & 0x80000000u ? ~(difference << 1) : difference << 1;
      for (size_t b = 0; b < 4; ++b) first[b * count + node] = char(folded >> 8 * b & 0xff);
    });
  });
  writer.addRaw(bytes);
}

VectorField fieldFrom(DecisionReader& reader, const Lattice& lattice, const VectorField& about) {
  const size_t count = lattice.count();
  const std::string bytes = reader.raw(3 * 4 * count);
  VectorField field(count);
  tbb::parallel_for(0, 3, [&](int c) {
    std::vector<float> off(count);
    const char* const first = &bytes[size_t(c) * 4 * count];
    visitInOrder(lattice, [&](size_t node, int x, int y, int z) {
      std::uint32_t folded = 0;
      for (size_t b = 0; b < 4; ++b) folded |= std::uint32_t(std::uint8_t(first[b * count + node])) << 8 * b;
      const float expected = about[node][c] + predicted(lattice, off, x, y, z);
      field[node][c] = ofOrder(orderOf(expected) + (folded & 1 ? ~(folded >> 1) : folded >> 1));
      off[node] = field[node][c] - about[node][c];
    });
  });
  return field;
}

/// The field that would make the sum of all 0, as the last one does where points move straight.
VectorField restOf(const std::vector<VectorField>& fields, size_t count) {
  VectorField rest(count, openvdb::Vec3s(0.f));
  for (const VectorField& field : fields)
    for (size_t i = 0; i < count; ++i) rest[i] -= field[i];
  return rest;
}

void addMap(DecisionWriter& writer, const Displacements& map) {
  const size_t count = map.lattice.count();
  writer.add(map.lattice.origin), writer.add(map.lattice.spacing);
  for (int c = 0; c < 3; ++c) writer.add(std::int32_t(map.lattice.size[c]));
  for (size_t k = 0; k < map.of.size(); ++k) {
    const bool last = k > 0 && k + 1 == map.of.size();
    const std::vector<VectorField> before(map.of.begin(), map.of.begin() + (last ? std::ptrdiff_t(k) : 0));
    addField(writer, map.lattice, map.of[k], restOf(before, count));
  }
}

Displacements mapFrom(DecisionReader& reader, size_t objects) {
  constexpr int kMost = 1 << 14;  // nodes along an axis
  Displacements map;
  map.lattice.origin = reader.vector(), map.lattice.spacing = reader.number<double>();
  for (int c = 0; c < 3; ++c) {
    map.lattice.size[c] = reader.number<std::int32_t>();
    if (map.lattice.size[c] < 1 || map.lattice.size[c] > kMost) refuseDecisions();
  }
  const size_t count = map.lattice.count();
  for (size_t k = 0; k < objects; ++k) {
    if (!reader.holds(count * 3 * sizeof(float))) refuseDecisions();
    const bool last = k > 0 && k + 1 == objects;
    map.of.push_back(
        fieldFrom(reader, map.lattice, restOf(last ? map.of : std::vector<VectorField>(), count)));
  }
  return map;
}

}  // namespace

std::string bytesOfDecisions(const Plan& plan) {
  DecisionWriter writer;
  writer.addCount(plan.shapes.levelSets.size());
  for (const FloatGrid::ConstPtr& levelSet : plan.shapes.levelSets) writer.add(checksumOf(*levelSet));
  writer.addCount(plan.frames.charts.size());
  for (const Chart& chart : plan.frames.charts) addChart(writer, chart);
  writer.addCount(plan.drawn.size());
  for (const Chart& chart : plan.drawn) addChart(writer, chart);
  writer.add(plan.frames.halfLength);
  writer.addCount(plan.frames.choices.size());
  for (const TurnChoice& choice : plan.frames.choices)
    writer.add(choice.degrees), writer.add(choice.distortion), writer.add(choice.margin);
  writer.add(plan.frames.notes);
  const Registration& registration = plan.registration;
  writer.addCount(registration.map.of.size());
  if (!registration.map.of.empty()) addMap(writer, registration.map);
  writer.add(std::uint8_t(registration.swings));
  writer.add(registration.overlapBefore), writer.add(registration.overlapAfter);
  writer.add(registration.notes);
  return std::move(writer).bytes();
}

Plan withDecisions(Plan plan, const std::string& bytes) {
  DecisionReader reader(bytes);
  const size_t shapes = plan.shapes.levelSets.size();
  bool same = reader.count(1) == shapes;
  for (size_t k = 0; same && k < shapes; ++k)
    same = reader.number<std::uint64_t>() == checksumOf(*plan.shapes.levelSets[k]);
  if (!same)
    throw InputError("the plan was made for other objects than these: other files, resolutions or values");
  plan.frames.charts.resize(reader.count(1)), plan.frames.notes.clear();
  for (Chart& chart : plan.frames.charts) chart = chartFrom(reader);
  plan.drawn.resize(reader.count(1));
  for (Chart& chart : plan.drawn) chart = chartFrom(reader);
  plan.frames.halfLength = reader.number<double>();
  plan.frames.choices.resize(reader.count(1));
  for (TurnChoice& choice : plan.frames.choices) {
    choice.degrees = reader.number<double>(), choice.distortion = reader.number<double>();
    choice.margin = reader.number<double>();
  }
  plan.frames.notes = reader.notes();
  const size_t mapped = reader.count(1);
  if (mapped != 0 && (mapped != shapes || plan.frames.charts.size() != shapes)) refuseDecisions();
  if (mapped == 0 && shapes > 1) refuseDecisions();
  if (mapped > 0) plan.registration.map = mapFrom(reader, mapped);
  plan.registration.swings = reader.number<std::uint8_t>() != 0;
  plan.registration.overlapBefore = reader.number<double>();
  plan.registration.overlapAfter = reader.number<double>();
  plan.registration.notes = reader.notes();
  if (!reader.atEnd()) refuseDecisions();
  return plan;
}

}  // namespace slicemorph
