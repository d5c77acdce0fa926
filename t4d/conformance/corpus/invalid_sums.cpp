#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "t4d/conformance/corpus/invalid.h"
#include "t4d/conformance/corpus/shapes.h"

/// Faults of DONE and INDX.
namespace t4d::conformance {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void addDoneFaults(InvalidCases& cases) {
  const Base base = layered();
  const Base open = baseOf({{"cross", crossPolytope()}}, {.index = false});
  const auto setIn = [&](const Base& of, const std::string& name, const std::string& fault,
                         const std::string& field, auto value) {
    cases.add(
        name, fault, of, [&](Image& image) { image.set("DONE/" + field, value); }, "DONE/" + field);
  };
  const auto set = [&](const std::string& name, const std::string& fault, const std::string& field,
                       auto value) { setIn(base, name, fault, field, value); };
  // HEAD, CONN, LAYR, SLAB, CONN, SLAB.
  set("D1-one-less", "One chunk less is counted: HEAD, as it seems.", "chunks", std::uint64_t{5});
  set("D1-one-more", "One chunk more is counted: DONE, as it seems.", "chunks", std::uint64_t{7});
  set("D1-zero", "No chunks are counted.", "chunks", std::uint64_t{0});
  set("D1-2-to-the-32-more", "2^32 chunks more are counted.", "chunks",
      (std::uint64_t{1} << 32) + 6);
  set("D1-2-to-the-64-less-1", "2^64 - 1 chunks are counted.", "chunks", kLargest);
  setIn(open, "D1-no-index", "One chunk more is counted.", "chunks", std::uint64_t{7});
  Base annotated = layered();
  annotated.image.add(noteChunk(3), "SLAB 1");
  setIn(annotated, "D1-without-optional-chunk", "The optional chunk is not counted.", "chunks",
        std::uint64_t{6});

  const Base two = baseOf({{"one", simplex()}, {"two", crossPolytope()}});
  cases.add(
      "D2-one-too-few", "HEAD names two bodies, DONE has one.", two,
      [](Image& image) {
        image.freeze("DONE");
        image.chunk("DONE").payload.truncate(16 + 88);
        image.set("DONE/bodies", 1U);
      },
      "DONE/bodies");
  cases.add(
      "D2-one-too-many", "HEAD names one body, DONE has two.", base,
      [](Image& image) {
        image.freeze("DONE");
        Record& payload = image.chunk("DONE").payload;
        payload.add("body 1", payload.part("body 0"));
        image.set("DONE/bodies", 2U);
      },
      "DONE/bodies");
  set("D2-zero", "DONE counts no body.", "bodies", 0U);
  set("D2-2-to-the-32-less-1", "DONE counts 2^32 - 1 bodies.", "bodies", ~0U);
  for (const int byte : {0, 3}) {
    cases.add(
        fmt::format("D3-reserved-byte-{}", byte), "A reserved byte is not zero.", base,
        [&](Image& image) { image.setBytes("DONE/reserved", "\x01", byte); }, "DONE/reserved",
        byte);
  }
  cases.add(
      "D4-bytes-after", "Eight bytes follow the last summary.", base,
      [](Image& image) {
        image.freeze("DONE");
        image.chunk("DONE").payload.putBytes("extra", std::string(8, '\0'));
      },
      "DONE/extra");
  cases.add(
      "D4-cut-off", "The last summary lacks its last number.", base,
      [](Image& image) {
        image.freeze("DONE");
        image.chunk("DONE").payload.truncate(16 + 80);
      },
      "DONE/header/length");
  cases.add(
      "D4-no-summary", "There is no summary.", base,
      [](Image& image) {
        image.freeze("DONE");
        image.chunk("DONE").payload.truncate(16);
      },
      "DONE/header/length");
  cases.add(
      "D4-empty", "The payload has no bytes.", base,
      [](Image& image) {
        image.freeze("DONE");
        image.chunk("DONE").payload.truncate(0);
      },
      "DONE/header/length");

  set("D5-one-less", "One slab less is counted.", "body 0/slabs", std::uint64_t{1});
  set("D5-one-more", "One slab more is counted.", "body 0/slabs", std::uint64_t{3});
  set("D5-zero", "No slab is counted.", "body 0/slabs", std::uint64_t{0});
  set("D5-2-to-the-32-more", "2^32 slabs more are counted.", "body 0/slabs",
      (std::uint64_t{1} << 32) + 2);
  set("D5-2-to-the-63", "2^63 slabs are counted.", "body 0/slabs", std::uint64_t{1} << 63);
  cases.add(
      "D5-body-without-slab", "The second body has no slab.",
      baseOf({{"one", simplex()}, {"two", simplex()}}),
      [](Image& image) {
        image = Image(headJson({}, {"one", "two"}));
        const model::Slab slab = simplex()[0];
        image.addConnectivity("CONN 0", *slab.connectivity);
        image.addSlab("SLAB 0", 0, slab, "CONN 0", "", "");
        image.summaries().resize(2);
        image.addEnd();
      },
      "DONE/body 1/slabs");
  setIn(two, "D5-of-other-body", "Slabs of the first body are counted for the second.",
        "body 1/slabs", std::uint64_t{3});
  // 7 + 7 minus the 6 of the shared layer.
  set("D6-shared-layer-twice", "The vertices of the shared layer are counted twice.",
      "body 0/vertices", std::uint64_t{14});
  set("D6-a-vertex-less", "One vertex less is counted.", "body 0/vertices", std::uint64_t{7});
  setIn(between(), "D6-first-layer-left-out", "The first lower layer is not counted.",
        "body 0/vertices", std::uint64_t{4});
  setIn(withMeans(), "D6-means-left-out", "The means are not counted.", "body 0/vertices",
        std::uint64_t{7});
  set("D6-a-cell-less", "One cell less is counted.", "body 0/cells", std::uint64_t{15});
  set("D6-a-cell-more", "One cell more is counted.", "body 0/cells", std::uint64_t{17});
  set("D6-2-to-the-32-vertices-more", "2^32 vertices more are counted.", "body 0/vertices",
      (std::uint64_t{1} << 32) + 8);
  set("D6-2-to-the-32-cells-more", "2^32 cells more are counted.", "body 0/cells",
      (std::uint64_t{1} << 32) + 16);
  set("D6-2-to-the-64-less-1", "2^64 - 1 cells are counted.", "body 0/cells", kLargest);
  set("D7-begin-earlier", "begin is earlier than that of the first slab.", "body 0/begin", -2.0);
  set("D7-begin-of-second-slab", "begin is that of the second slab.", "body 0/begin", 0.0);
  set("D7-end-of-first-slab", "end is that of the first slab.", "body 0/end", 0.0);
  set("D7-end-later", "end is later than that of the last slab.", "body 0/end",
      std::nextafter(1.0, 2.0));
  set("D7-begin-nan", "begin is NaN.", "body 0/begin", kNaN);
  set("D7-end-infinity", "end is infinite.", "body 0/end", kInfinity);
  for (const char* corner : {"minimum", "maximum"}) {
    const double sign = corner[1] == 'i' ? -1 : 1;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string field = fmt::format("body 0/{} {}", corner, axis);
      set(fmt::format("D8-{}-{}-beyond", corner, "xyz"[axis]),
          fmt::format("The {} of {} is beyond that of the vertices.", corner, "xyz"[axis]), field,
          sign * std::nextafter(1.0, 2.0));
      set(fmt::format("D8-{}-{}-within", corner, "xyz"[axis]),
          fmt::format("The {} of {} is within that of the vertices.", corner, "xyz"[axis]), field,
          sign * 0.5);
    }
  }
  set("D8-minimum-nan", "A minimum is NaN.", "body 0/minimum 1", kNaN);
  set("D8-maximum-infinity", "A maximum is infinite.", "body 0/maximum 1", kInfinity);
  // 0.1 is less in binary64 than in binary32.
  const Base rounded = baseOf({{"simplex", simplex(1, {0.1, 0.1, 0.1, 0})}}, {.float32 = true});
  setIn(rounded, "D8-before-rounding",
        "A minimum is that of the numbers before they were rounded "
        "to binary32.",
        "body 0/minimum 0", 0.1);
  model::Slab nothing;
  nothing.connectivity = std::make_shared<model::Connectivity>();
  const Base empty = baseOf({{"nothing", {nothing}}, {"simplex", simplex()}});
  for (const char* corner : {"minimum", "maximum"}) {
    cases.add(
        fmt::format("D8-{}-of-nothing-0", corner),
        fmt::format("The {} of a body without vertices is 0.", corner), empty,
        [&](Image& image) {
          for (int axis = 0; axis < 3; ++axis) {
            image.set(fmt::format("DONE/body 0/{} {}", corner, axis), 0.0);
          }
        },
        fmt::format("DONE/body 0/{} 0", corner));
  }
}

void addIndexFaults(InvalidCases& cases) {
  const Base base = layered();
  const auto set = [&](const std::string& name, const std::string& fault, const std::string& field,
                       auto value) {
    cases.add(
        name, fault, base, [&](Image& image) { image.set("INDX/" + field, value); },
        "INDX/" + field);
  };
  const auto changed = [&](const std::string& name, const std::string& fault,
                           const std::function<void(Record&)>& change, const std::string& place) {
    cases.add(
        name, fault, base,
        [&](Image& image) {
          image.freeze("INDX");
          change(image.chunk("INDX").payload);
        },
        "INDX/" + place);
  };
  set("I1-one-less", "One slab is counted, two records are there.", "slabs", std::uint64_t{1});
  set("I1-one-more", "Three slabs are counted, two records are there.", "slabs", std::uint64_t{3});
  set("I1-2-to-the-32-more", "2^32 + 2 slabs are counted.", "slabs", (std::uint64_t{1} << 32) + 2);
  set("I1-2-to-the-58-more", "2^58 + 2 slabs are counted: 64 bytes each are 128 modulo 2^64.",
      "slabs", (std::uint64_t{1} << 58) + 2);
  changed(
      "I1-record-missing", "The record of the last slab is missing.",
      [](Record& payload) {
        payload.truncate(8 + 64);
        payload.overwrite("slabs", bytesOf(std::uint64_t{1}));
      },
      "slabs");
  changed(
      "I1-first-record-missing", "The record of the first slab is missing.",
      [](Record& payload) {
        payload.overwrite("record 0", payload.part("record 1").bytes());
        payload.truncate(8 + 64);
        payload.overwrite("slabs", bytesOf(std::uint64_t{1}));
      },
      "slabs");
  changed(
      "I1-record-too-many", "The record of the last slab is there twice.",
      [](Record& payload) {
        payload.add("record 2", payload.part("record 1"));
        payload.overwrite("slabs", bytesOf(std::uint64_t{3}));
      },
      "slabs");
  changed(
      "I1-bytes-after", "Eight bytes follow the last record.",
      [](Record& payload) { payload.putBytes("extra", std::string(8, '\0')); }, "extra");
  changed(
      "I1-cut-off", "The last record lacks its last 8 bytes.",
      [](Record& payload) { payload.truncate(payload.size() - 8); }, "record 1/body");
  changed(
      "I1-no-records", "No slab is counted.",
      [](Record& payload) {
        payload.truncate(8);
        payload.overwrite("slabs", bytesOf(std::uint64_t{0}));
      },
      "slabs");
  changed(
      "I1-empty", "The payload has no bytes.", [](Record& payload) { payload.truncate(0); },
      "header/length");

  const auto offset = [&](const char* place) { return base.image.offset(place); };
  set("I2-offset-of-payload", "The offset is that of a SLAB's payload.", "record 1/slab",
      offset("SLAB 1"));
  set("I2-offset-of-connectivity", "The offset is that of a CONN.", "record 1/slab",
      offset("CONN 1/header"));
  set("I2-offset-zero", "The offset is 0.", "record 0/slab", std::uint64_t{0});
  set("I2-offset-off-by-one", "The offset is one too large.", "record 0/slab",
      offset("SLAB 0/header") + 1);
  set("I2-offset-of-the-end", "The offset is the length of the file.", "record 1/slab",
      std::uint64_t{base.image.bytes().size()});
  set("I2-offset-2-to-the-32-more", "The offset is 2^32 too large.", "record 1/slab",
      offset("SLAB 1/header") + (std::uint64_t{1} << 32));
  set("I2-offset-2-to-the-64-less-8", "The offset is 2^64 - 8.", "record 1/slab", kLargest - 7);
  const std::uint64_t size =
      base.image.offset("CONN 1/header") - base.image.offset("SLAB 0/header");
  set("I2-size-8-less", "The size is 8 bytes too small.", "record 0/size", size - 8);
  set("I2-size-without-header", "The size does not count the header.", "record 0/size", size - 24);
  set("I2-size-2-to-the-32-more", "The size is 2^32 too large.", "record 0/size",
      size + (std::uint64_t{1} << 32));
  set("I2-size-zero", "The size is 0.", "record 0/size", std::uint64_t{0});
  set("I2-size-2-to-the-64-less-1", "The size is 2^64 - 1.", "record 0/size", kLargest);
  changed(
      "I2-other-order", "The records are in the other order.",
      [](Record& payload) {
        const std::string first = payload.part("record 0").bytes();
        payload.overwrite("record 0", payload.part("record 1").bytes());
        payload.overwrite("record 1", first);
      },
      "record 0");
  changed(
      "I2-one-twice", "Both records are of the first slab.",
      [](Record& payload) { payload.overwrite("record 1", payload.part("record 0").bytes()); },
      "record 1");

  set("I3-begin", "begin is another.", "record 0/begin", -2.0);
  set("I3-begin-nan", "begin is NaN.", "record 0/begin", kNaN);
  set("I3-end", "end is another.", "record 1/end", 2.0);
  set("I3-end-by-a-bit", "end is the next number.", "record 1/end", std::nextafter(1.0, 2.0));
  set("I3-end-infinity", "end is infinite.", "record 1/end", kInfinity);
  set("I3-connectivity", "connectivity is another CONN.", "record 1/connectivity",
      offset("CONN 0/header"));
  set("I3-connectivity-zero", "connectivity is 0.", "record 1/connectivity", std::uint64_t{0});
  set("I3-lower-zero", "lower is 0.", "record 1/lower", std::uint64_t{0});
  set("I3-lower-of-slab", "lower is the offset of a SLAB.", "record 1/lower",
      offset("SLAB 0/header"));
  set("I3-upper", "upper is a LAYR where the slab has none.", "record 1/upper",
      offset("LAYR 0/header"));
  set("I3-upper-zero", "upper is 0.", "record 0/upper", std::uint64_t{0});
  set("I3-body", "body is 1, of 1.", "record 0/body", 1U);
  // Both bodies have one slab at the same times, so that sums and order stay valid.
  const Base two = baseOf({{"one", simplex()}, {"two", simplex()}});
  cases.add(
      "I3-bodies-exchanged", "The records say each other's body.", two,
      [](Image& image) {
        image.set("INDX/record 0/body", 1U);
        image.set("INDX/record 1/body", 0U);
      },
      "INDX/record 0/body");
  cases.add(
      "I3-both-layers-moved", "The index leaves out the layer on both sides.", base,
      [](Image& image) {
        image.set("INDX/record 0/upper", std::uint64_t{0});
        image.set("INDX/record 1/lower", std::uint64_t{0});
      },
      "INDX/record 0/upper");
  for (const int byte : {0, 3}) {
    cases.add(
        fmt::format("I4-reserved-byte-{}", byte), "A reserved byte is not zero.", base,
        [&](Image& image) { image.setBytes("INDX/record 1/reserved", "\x01", byte); },
        "INDX/record 1/reserved", byte);
  }
}

}  // namespace t4d::conformance
