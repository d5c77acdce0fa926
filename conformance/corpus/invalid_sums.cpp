#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/format.h>

#include "conformance/corpus/invalid.h"
#include "conformance/corpus/shapes.h"

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
  // Overwrites a number of an array, or of another field.
  const auto set = [&](const std::string& name, const std::string& fault, const std::string& field,
                       auto value, std::size_t at = 0) {
    const std::string place = "INDX/" + field;
    cases.add(
        name, fault, base, [&](Image& image) { image.setBytes(place, bytesOf(value), at); }, place,
        at);
  };
  // Replaces the content of an array.
  const auto replace = [&](const std::string& name, const std::string& fault, const Base& of,
                           const std::string& array, std::uint8_t type, std::uint8_t components,
                           std::uint64_t rows,
                           const std::function<std::string(std::string)>& change) {
    cases.add(
        name, fault, of,
        [&](Image& image) {
          image.freeze("INDX");
          Record& payload = image.chunk("INDX").payload;
          const std::string content = change(payload.contents(array + "/stored"));
          payload.replace(
              array, arrayRecord(type, components, 0, rows,
                                 rows == 0 ? std::vector<std::string>() : std::vector{content}));
        },
        "INDX/" + array + "/rows");
  };
  const auto same = [](std::string content) { return content; };
  const auto fewer = [](std::size_t bytes) {
    return [bytes](std::string content) { return content.substr(0, content.size() - bytes); };
  };

  set("I1-minor-version", "The copy of the file header has another minor version.", "file header",
      std::uint16_t{1}, 10);
  set("I1-file-header-zero", "The copy of the file header is zero.", "file header",
      std::uint64_t{0}, 0);
  const std::string head = Image(base.image).chunk("HEAD").payload.bytes();
  set("I1-name", "The copy of HEAD has another name.", "head/stored", 'C', head.find("cross"));
  cases.refusedAt(0.5);
  const std::uint64_t headBytes = base.image.size("HEAD");
  replace("I1-head-cut-off", "The copy of HEAD lacks its last byte.", base, "head", 1, 1,
          headBytes - 1, fewer(1));
  replace("I1-no-head", "The copy of HEAD has no bytes.", base, "head", 1, 1, 0, same);

  // HEAD, CONN, LAYR, SLAB, CONN, SLAB, DONE.
  replace("I2-header-missing", "The header of the last chunk is missing.", base, "chunks", 1, 28, 6,
          fewer(28));
  replace("I2-head-missing", "The header of HEAD is missing.", base, "chunks", 1, 28, 6,
          [](const std::string& content) { return content.substr(28); });
  replace("I2-header-too-many", "The header of INDX is there, too.", base, "chunks", 1, 28, 8,
          [&](const std::string& content) {
            return content + base.image.bytes().substr(base.image.offset("INDX/header"), 28);
          });
  replace("I2-two-exchanged", "The headers of a LAYR and a CONN are exchanged.", base, "chunks", 1,
          28, 7, [](const std::string& content) {
            return content.substr(0, 28) + content.substr(56, 28) + content.substr(28, 28) +
                   content.substr(84);
          });
  replace("I2-no-chunks", "There are no headers.", base, "chunks", 1, 28, 0, same);
  set("I2-length-8-less", "A header has another length than in the file.", "chunks/stored",
      std::uint64_t{base.image.size("CONN 0") - 8}, 28 + 8);
  set("I2-length-2-to-the-64-less-8", "A header has the length 2^64 - 8.", "chunks/stored",
      kLargest - 7, 28 + 8);
  set("I2-checksum", "A header has another checksum than in the file.", "chunks/stored", 0U,
      3 * 28 + 24);
  Base annotated = layered();
  annotated.image.add(noteChunk(3), "SLAB 1");
  replace("I2-optional-chunk-missing", "The header of an optional chunk is missing.", annotated,
          "chunks", 1, 28, 7, [](const std::string& content) {
            return content.substr(0, 5 * 28) + content.substr(6 * 28);
          });

  // A chunk is exchanged for another of its size; all checksums are right, and INDX is as before. A
  // slice that reads the chunk must be refused.
  const auto exchanged = [&](const std::string& name, const std::string& what, const Base& of,
                             const std::string& chunk, double time,
                             const std::function<void(Image&)>& change) {
    cases.add(
        "I2-" + name,
        "A " + what + " is exchanged for another, and INDX is that of the file before.", of,
        [&](Image& image) {
          image.freeze("INDX");
          change(image);
        },
        chunk + "/header/front checksum");
    cases.refusedAt(time);
  };
  exchanged("slab-exchanged", "SLAB", plain(), "SLAB 0", 0.5, [](Image& image) {
    image.setBytes("SLAB 0/interior positions/stored",
                   bytesOf(0.25) + bytesOf(0.25) + bytesOf(0.25));
  });
  exchanged("connectivity-exchanged", "CONN", plain(), "CONN 0", 0.5,
            [](Image& image) { image.setBytes("CONN 0/cells/stored", bytesOf(2U) + bytesOf(1U)); });
  exchanged("layer-exchanged", "LAYR", base, "LAYR 0", 0.5,
            [](Image& image) { image.setBytes("LAYR 0/positions/stored", bytesOf(0.5), 8); });
  exchanged("pose-exchanged", "POSE", withPoses(), "POSE 1", 1.5, [](Image& image) {
    for (const char* field : {"m00", "m11"}) image.set("POSE 1/" + std::string(field), 0.0);
    for (const char* field : {"m01", "m10"}) image.set("POSE 1/" + std::string(field), 1.0);
  });
  exchanged("end-mark-exchanged", "DONE", base, "DONE", 0.5,
            [](Image& image) { image.set("DONE/body 0/maximum 0", 2.0); });

  set("I3-one-less", "One slab is counted, two are there.", "slabs", std::uint32_t{1});
  set("I3-one-more", "Three slabs are counted, two are there.", "slabs", std::uint32_t{3});
  set("I3-zero", "No slab is counted.", "slabs", std::uint32_t{0});
  set("I3-2-to-the-32-less-1", "2^32 - 1 slabs are counted.", "slabs", ~0U);
  struct Column {
    const char* name;
    std::uint8_t type;
    std::uint8_t components;
    std::size_t rowBytes;
  };
  const Column columns[] = {{"times", 10, 2, 16},
                            {"parts", 7, 3, 24},
                            {"bodies", 5, 1, 4},
                            {"cells", 7, 1, 8},
                            {"bounds", 10, 6, 48}};
  for (const auto& [name, type, components, rowBytes] : columns) {
    replace(fmt::format("I3-row-of-{}-missing", name),
            fmt::format("The last slab has no row in {}.", name), base, name, type, components, 1,
            fewer(rowBytes));
    replace(fmt::format("I3-row-of-{}-too-many", name),
            fmt::format("{} has a row more than there are slabs.", name), base, name, type,
            components, 3, [rowBytes = rowBytes](const std::string& content) {
              return content + content.substr(content.size() - rowBytes);
            });
    replace(fmt::format("I7-type-of-{}", name), fmt::format("{} is of another type.", name), base,
            name,
            type == 10  ? 8
            : type == 7 ? 8
                        : 6,
            components, 2, same);
    // The bytes are kept, but read as rows of another number of components.
    const std::size_t size = model::scalarSize(static_cast<model::ScalarType>(type));
    const std::uint8_t other = components == 1 ? 2 : 1;
    replace(fmt::format("I7-components-of-{}", name),
            fmt::format("{} has {} components.", name, other), base, name, type, other,
            2 * rowBytes / size / other, same);
  }
  replace("I7-type-of-head", "The copy of HEAD is of signed integers.", base, "head", 2, 1,
          headBytes, same);
  cases.add(
      "I7-compressed-head", "The copy of HEAD is compressed.",
      baseOf({{"cross", crossPolytope()}}, {.storage = Storage::Library}),
      [](Image& image) {
        image.freeze("INDX");
        Record& payload = image.chunk("INDX").payload;
        payload.replace("head", arrayRecord(model::ScalarType::UInt8, 1,
                                            payload.contents("head/stored"), Storage::Library));
      },
      "INDX/head/codec");
  replace("I7-components-of-chunks", "The headers are single bytes.", base, "chunks", 1, 1, 7 * 28,
          same);

  const auto to = [&](const char* slab, const char* place) {
    return base.image.offset(slab) - base.image.offset(place);
  };
  // A slice that reads the slab of this row must be refused.
  const auto setRow = [&](const std::string& name, const std::string& fault,
                          const std::string& column, auto value, std::size_t at = 0) {
    set(name, fault, column + "/stored", value, at);
    const bool isFirst = at < std::ranges::find(columns, column, &Column::name)->rowBytes;
    cases.refusedAt(isFirst ? -0.5 : 0.5);
  };
  setRow("I4-begin", "begin is another.", "times", -2.0, 0);
  setRow("I4-begin-nan", "begin is NaN.", "times", kNaN, 0);
  setRow("I4-end", "end is another.", "times", 2.0, 24);
  setRow("I4-end-by-a-bit", "end is the next number.", "times", std::nextafter(1.0, 2.0), 24);
  setRow("I4-end-infinity", "end is infinite.", "times", kInfinity, 24);
  setRow("I4-connectivity", "connectivity is another CONN.", "parts",
         to("SLAB 1/header", "CONN 0/header"), 24);
  setRow("I4-connectivity-zero", "connectivity is 0.", "parts", std::uint64_t{0}, 24);
  setRow("I4-connectivity-of-payload", "connectivity names a payload.", "parts",
         to("SLAB 1/header", "CONN 1"), 24);
  setRow("I4-lower-zero", "lower is 0.", "parts", std::uint64_t{0}, 24 + 8);
  setRow("I4-lower-of-slab", "lower names a SLAB.", "parts", to("SLAB 1/header", "SLAB 0/header"),
         24 + 8);
  setRow("I4-upper", "upper is a LAYR where the slab has none.", "parts",
         to("SLAB 1/header", "LAYR 0/header"), 24 + 16);
  setRow("I4-upper-zero", "upper is 0.", "parts", std::uint64_t{0}, 16);
  setRow("I4-upper-2-to-the-64-less-8", "upper is 2^64 - 8.", "parts", kLargest - 7, 16);
  setRow("I4-body", "body is 1, of 1.", "bodies", 1U);
  // Both bodies have one slab at the same times, so that sums and order stay valid.
  const Base two = baseOf({{"one", simplex()}, {"two", simplex()}});
  cases.add(
      "I4-bodies-exchanged", "The slabs have each other's body.", two,
      [](Image& image) { image.setBytes("INDX/bodies/stored", bytesOf(1U) + bytesOf(0U)); },
      "INDX/bodies/stored");
  cases.refusedAt(0.5);
  cases.add(
      "I4-both-layers-moved", "The index leaves out the layer on both sides.", base,
      [](Image& image) {
        image.setBytes("INDX/parts/stored", bytesOf(std::uint64_t{0}), 16);
        image.setBytes("INDX/parts/stored", bytesOf(std::uint64_t{0}), 24 + 8);
      },
      "INDX/parts/stored", 16);
  cases.refusedAt(0.5);
  setRow("I5-one-less", "A slab has one cell more than the index says.", "cells", std::uint64_t{7},
         8);
  setRow("I5-zero", "The index says that a slab has no cells.", "cells", std::uint64_t{0});
  setRow("I5-2-to-the-32-more", "The index says that a slab has 2^32 + 8 cells.", "cells",
         (std::uint64_t{1} << 32) + 8);
  for (int axis = 0; axis < 3; ++axis) {
    setRow(fmt::format("I6-minimum-{}", "xyz"[axis]),
           fmt::format("The minimum of {} is beyond that of the slab.", "xyz"[axis]), "bounds",
           -2.0, std::size_t{8} * axis);
    setRow(fmt::format("I6-maximum-{}", "xyz"[axis]),
           fmt::format("The maximum of {} is within that of the slab.", "xyz"[axis]), "bounds", 0.5,
           48 + 24 + std::size_t{8} * axis);
  }
  setRow("I6-nan", "A minimum is NaN.", "bounds", kNaN, 8);
  cases.add(
      "I8-bytes-after", "Eight bytes follow the last array.", base,
      [](Image& image) {
        image.freeze("INDX");
        image.chunk("INDX").payload.putBytes("extra", std::string(8, '\0'));
      },
      "INDX/extra");
  cases.add(
      "I8-block-left", "A block belongs to no array.", base,
      [](Image& image) {
        image.freeze("INDX");
        image.chunk("INDX").payload.putBlock("extra", std::string(8, '\0'));
      },
      "INDX/extra");
  for (const std::size_t size : {std::size_t{0}, std::size_t{16}, std::size_t{24}}) {
    cases.add(
        fmt::format("I8-cut-off-at-{}", size), fmt::format("The fields end after {} bytes.", size),
        base,
        [&](Image& image) {
          image.freeze("INDX");
          image.chunk("INDX").payload.truncate(size);
        },
        "INDX/header/length");
  }
}

}  // namespace t4d::conformance
