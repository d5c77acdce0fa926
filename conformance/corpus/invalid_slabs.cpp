#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "conformance/corpus/invalid.h"
#include "conformance/corpus/shapes.h"

/// Faults of CONN, LAYR and SLAB, and of how they fit together.
namespace t4d::conformance {
namespace {

using namespace std::string_literals;
using model::Connectivity;
using model::Domain;
using model::Point4;
using model::ScalarType;
using model::Slab;

/// `count` zero bytes.
std::string zeros(std::size_t count) { return std::string(count, '\0'); }

/// The second half of a cross-polytope, beginning with the layer at t = 0.
Slab upperHalf() { return crossPolytope()[1]; }

/// Replaces the interior vertices of SLAB 0 by these.
void storeInterior(Image& image, std::span<const Point4> vertices) {
  const Record record = slabRecord({0, 1}, 0, {}, vertices, {}, {}, Storage::Raw);
  Record& payload = image.chunk("SLAB 0").payload;
  for (const char* array : {"interior positions", "interior times"}) {
    payload.replace(array, record.part(array));
  }
}

/// The payload `of` a chunk with another number in the field `counted` and `bytes` in front of its
/// first array, for what is there.
Record withCounted(const Record& of, const std::string& counted, std::uint32_t count,
                   const std::string& bytes, const std::vector<std::string>& fields,
                   const std::vector<std::string>& arrays) {
  Record record;
  for (const std::string& field : fields) record.putBytes(field, of.contents(field));
  record.overwrite(counted, bytesOf(count));
  record.putBytes("counted", bytes);
  for (const std::string& array : arrays) record.add(array, of.part(array));
  return record;
}

/// CONN 0 with `count` ranges, these.
void storeRanges(Image& image, std::uint32_t count, const std::string& ranges) {
  Record& payload = image.chunk("CONN 0").payload;
  payload = withCounted(payload, "ranges", count, ranges,
                        {"vertices", "lower", "upper", "means", "attributes", "ranges"}, {"cells"});
}

struct NotFinite {
  const char* name;
  double value;
};
constexpr NotFinite kNotFinite[] = {{"nan", std::numeric_limits<double>::quiet_NaN()},
                                    {"infinity", kInfinity},
                                    {"negative-infinity", -kInfinity}};

}  // namespace

void addConnectivityFaults(InvalidCases& cases) {
  const Base base = plain();
  const Base means = withMeans();
  const auto set = [&](const std::string& name, const std::string& fault, const Base& of,
                       const std::string& field, std::uint32_t value, std::size_t at = 0) {
    cases.add(
        name, fault, of,
        [&](Image& image) { image.setBytes("CONN 0/" + field, bytesOf(value), at); },
        "CONN 0/" + field, at);
  };
  const auto replace = [&](const std::string& name, const std::string& fault, const Base& of,
                           const std::string& array, const Record& record,
                           const std::string& field) {
    cases.add(
        name, fault, of,
        [&](Image& image) { image.chunk("CONN 0").payload.replace(array, record); },
        "CONN 0/" + array + "/" + field);
  };
  set("N1-lower-layer", "The lower layer has more vertices than the slab.", base, "lower", 6);
  set("N1-upper-layer", "The upper layer has more vertices than the slab.", base, "upper", 6);
  set("N1-means", "Layers and means together are more than the vertices.", means, "vertices", 1);
  cases.add(
      "N1-both-layers", "Both layers together have more vertices than the slab.", base,
      [](Image& image) {
        image.set("CONN 0/lower", 3U);
        image.set("CONN 0/upper", 3U);
      },
      "CONN 0/lower");
  cases.add(
      "N1-sum-wraps", "The vertices of both layers are 2^32, which is 0 in 32 bits.", base,
      [](Image& image) {
        image.set("CONN 0/lower", 1U << 31);
        image.set("CONN 0/upper", 1U << 31);
      },
      "CONN 0/lower");
  set("N1-2-to-the-32-less-1", "The upper layer has 2^32 - 1 vertices.", base, "upper", ~0U);
  const Base two = baseOf({{"simplices", {manySimplices()}}}, {.storage = Storage::Repeats});
  set("N2-first-vertex", "The range of a block begins a vertex too early.", two, "range 1", 65534,
      8);
  set("N2-last-vertex", "The range of a block ends a vertex too early.", two, "range 0", 65535, 12);
  set("N2-of-a-layer", "A block has a range of the lower layer, which is empty.", two, "range 0", 1,
      4);
  const auto storing = [&](const std::string& name, const std::string& fault, const Base& of,
                           std::uint32_t count, const std::string& ranges) {
    cases.add(
        name, fault, of, [&](Image& image) { storeRanges(image, count, ranges); }, "CONN 0/ranges");
  };
  const Record ofTwo = Image(two.image).chunk("CONN 0").payload;
  const std::string first = ofTwo.contents("range 0");
  storing("N2-range-missing", "Two blocks of cells have one range.", two, 1, first);
  storing("N2-no-ranges", "Two blocks of cells have no ranges.", two, 0, "");
  storing("N2-range-too-many", "Two blocks of cells have three ranges.", two, 3,
          first + ofTwo.contents("range 1") + first);
  storing("N2-range-of-one-block", "A range is there, right, of one block of cells.", base, 1,
          zeros(12) + bytesOf(5U) + zeros(8));
  set("N11-range-missing", "A range is counted that is not there.", base, "ranges", 1);
  set("N11-ranges-2-to-the-32-less-1", "2^32 - 1 ranges are counted.", base, "ranges", ~0U);

  std::string indices;
  std::string wide;
  std::string narrow;
  const std::vector<Slab> slabs = simplex();
  for (const model::Cell& cell : slabs[0].connectivity->cells) {
    for (const std::uint32_t index : cell) {
      indices += bytesOf(index);
      wide += bytesOf(std::uint64_t{index});
      narrow += bytesOf(static_cast<std::uint16_t>(index));
    }
  }
  replace("N3-type-7", "The cells are of 64-bit integers.", base, "cells",
          arrayRecord(ScalarType::UInt64, 4, wide, Storage::Raw), "scalar type");
  replace("N3-type-6", "The cells are of signed integers.", base, "cells",
          arrayRecord(ScalarType::Int32, 4, indices, Storage::Raw), "scalar type");
  replace("N3-type-3", "The cells are of 16-bit integers.", base, "cells",
          arrayRecord(ScalarType::UInt16, 4, narrow, Storage::Raw), "scalar type");
  replace("N3-type-9", "The cells are of floating-point numbers.", base, "cells",
          arrayRecord(ScalarType::Float32, 4, indices, Storage::Raw), "scalar type");
  replace("N3-5-components", "The cells have five indices.", base, "cells",
          arrayRecord(ScalarType::UInt32, 5, indices, Storage::Raw), "components");
  replace("N3-1-component", "The cells have one index.", base, "cells",
          arrayRecord(ScalarType::UInt32, 1, indices, Storage::Raw), "components");
  set("N4-vertex-5-of-5", "A cell has the vertex 5, of 5.", base, "cells/stored", 5, 4 * 6);
  set("N4-second-vertex-5-of-5", "The second vertex of a cell is 5, of 5.", base, "cells/stored", 5,
      4 * 5);
  set("N4-2-to-the-32-less-1", "A cell has the vertex 2^32 - 1.", base, "cells/stored", ~0U, 76);
  set("N4-2-to-the-31", "A cell has the vertex 2^31.", base, "cells/stored", 1U << 31, 0);
  // Cell 4 is (0, 1, 2, 3).
  for (const auto& [name, value, corner] : {std::tuple{"first-and-second", 0U, 1U},
                                            {"first-and-last", 0U, 3U},
                                            {"third-and-last", 2U, 3U}}) {
    set(fmt::format("N5-{}", name), fmt::format("A cell has the vertex {} twice.", value), base,
        "cells/stored", value, 64 + std::size_t{4} * corner);
  }
  cases.add(
      "N5-all-four", "A cell has the vertex 0 four times.", base,
      [](Image& image) { image.setBytes("CONN 0/cells/stored", zeros(16), 16); },
      "CONN 0/cells/stored", 16);

  const std::string sizes = bytesOf(4U) + bytesOf(2U);
  const std::string sources =
      bytesOf(0U) + bytesOf(1U) + bytesOf(2U) + bytesOf(6U) + bytesOf(5U) + bytesOf(6U);
  const auto sizesRecord = [](ScalarType type, std::uint8_t components, const std::string& bytes) {
    return arrayRecord(type, components, bytes, Storage::Raw);
  };
  replace("N6-sizes-of-type-3", "The mean sizes are of 16-bit integers.", means, "mean sizes",
          sizesRecord(ScalarType::UInt16, 1, "\x04\0\x02\0"s), "scalar type");
  replace("N6-sizes-of-2-components", "The mean sizes have two numbers in a row.", means,
          "mean sizes", sizesRecord(ScalarType::UInt32, 2, sizes + sizes), "components");
  replace("N6-a-size-too-few", "Two means have one size.", means, "mean sizes",
          sizesRecord(ScalarType::UInt32, 1, bytesOf(6U)), "rows");
  replace("N6-a-size-too-many", "Two means have three sizes.", means, "mean sizes",
          sizesRecord(ScalarType::UInt32, 1, bytesOf(3U) + bytesOf(2U) + bytesOf(1U)), "rows");
  replace("N6-sources-of-type-6", "The mean sources are of signed integers.", means, "mean sources",
          sizesRecord(ScalarType::Int32, 1, sources), "scalar type");
  replace("N6-sources-of-2-components", "The mean sources have two numbers in a row.", means,
          "mean sources", sizesRecord(ScalarType::UInt32, 2, sources), "components");
  cases.add(
      "N7-mean-of-nothing", "A mean has no sources.", means,
      [&](Image& image) { image.setBytes("CONN 0/mean sizes/stored", bytesOf(6U) + bytesOf(0U)); },
      "CONN 0/mean sizes/stored", 4);
  set("N8-a-source-too-few", "The means have 7 sources, of which 6 are listed.", means,
      "mean sizes/stored", 3, 4);
  set("N8-a-source-too-many", "The means have 5 sources, and 6 are listed.", means,
      "mean sizes/stored", 3, 0);
  cases.add(
      "N8-sum-wraps", "The mean sizes are 6 in 32 bits, and 2^32 more.", means,
      [](Image& image) { image.setBytes("CONN 0/mean sizes/stored", bytesOf(7U) + bytesOf(~0U)); },
      "CONN 0/mean sizes/stored", 4);
  set("N9-vertex-9-of-9", "A mean has the source 9, of 9 vertices.", means, "mean sources/stored",
      9, 8);
  set("N9-2-to-the-32-less-1", "A mean has the source 2^32 - 1.", means, "mean sources/stored", ~0U,
      20);
  set("N9-itself", "A mean is a source of itself.", means, "mean sources/stored", 7, 0);
  set("N9-mean-before", "A mean is a source of the next.", means, "mean sources/stored", 7, 16);
  set("N9-mean-after", "A mean is a source of the one before.", means, "mean sources/stored", 8, 0);

  const auto ofDomain = [](Domain domain) {
    std::vector<Slab> with = simplex();
    auto connectivity = std::make_shared<Connectivity>(*with[0].connectivity);
    connectivity->cellAttributes = {
        model::makeAttribute<std::uint8_t>("a", domain, {1, 2, 3, 4, 5})};
    with[0].connectivity = connectivity;
    return baseOf({{"simplex", with}});
  };
  cases.add(
      "N10-vertex-attribute", "A CONN has a vertex attribute.", ofDomain(Domain::Cell),
      [&](Image& image) { image = ofDomain(Domain::Vertex).image; }, "CONN 0/attribute 0/domain");
  cases.add(
      "N10-of-no-vertex", "A CONN has a vertex attribute of no rows; its slab has no interior.",
      between(),
      [](Image& image) {
        image.chunk("CONN 0").payload.add(
            "attribute 0",
            attributeRecord(model::makeAttribute<std::uint8_t>("a", Domain::Vertex, {}),
                            Storage::Raw));
        image.set("CONN 0/attributes", 1U);
      },
      "CONN 0/attribute 0/domain");
  cases.add(
      "N11-bytes-after", "Eight bytes follow the last part of the payload.", base,
      [](Image& image) { image.chunk("CONN 0").payload.putBytes("extra", zeros(8)); },
      "CONN 0/extra");
  set("N11-attribute-not-counted", "An attribute follows that is not counted.",
      ofDomain(Domain::Cell), "attributes", 0);
  set("N11-attribute-missing", "An attribute is counted that is not there.", base, "attributes", 1);
  set("N11-attributes-2-to-the-32-less-1", "2^32 - 1 attributes are counted.", base, "attributes",
      ~0U);
  cases.add(
      "N11-empty", "The payload has no bytes.", base,
      [](Image& image) { image.chunk("CONN 0").payload.truncate(0); }, "CONN 0/header/length");
  cases.add(
      "N11-cut-off", "The payload ends within its fixed part.", base,
      [](Image& image) {
        image.chunk("CONN 0").payload.truncate(20);
        image.chunk("CONN 0").payload.dropBlocks();
      },
      "CONN 0/header/length");
  cases.add(
      "N11-record-cut-off", "The fields end within the record of an array.", base,
      [](Image& image) { image.chunk("CONN 0").payload.truncate(24 + 8); }, "CONN 0/header/length");
  cases.add(
      "N11-no-array", "The fields end where an array should begin.", base,
      [](Image& image) { image.chunk("CONN 0").payload.truncate(24); }, "CONN 0/header/length");
  cases.add(
      "N11-block-left", "A block belongs to no array.", base,
      [](Image& image) { image.chunk("CONN 0").payload.putBlock("extra", zeros(8)); },
      "CONN 0/extra");
  set("N11-means-not-counted", "There are no means, and the arrays of means follow.", means,
      "means", 0);
  cases.add(
      "N12-means-not-named", "The file does not name the feature means, which it uses.", means,
      [](Image& image) {
        image = Image::of({{"simplex", {meansSlab()}}}, {}, headJson({}, {"simplex"}));
      },
      "CONN 0/means");
}

void addLayerFaults(InvalidCases& cases) {
  const Base base = between();
  for (const auto& [name, value] : kNotFinite) {
    cases.add(
        fmt::format("L1-time-{}", name), fmt::format("The time is {}.", value), base,
        [v = value](Image& image) { image.set("LAYR 1/time", v); }, "LAYR 1/time");
    cases.add(
        fmt::format("L1-time-of-posed-{}", name),
        fmt::format("The time of a LAYR that only POSEs name is {}.", value), withPoses(),
        [v = value](Image& image) { image.set("LAYR 1/time", v); }, "LAYR 1/time");
  }
  const auto replace = [&](const std::string& name, const std::string& fault, const Record& record,
                           const std::string& field) {
    cases.add(
        name, fault, base,
        [&](Image& image) { image.chunk("LAYR 1").payload.replace("positions", record); },
        "LAYR 1/positions/" + field);
  };
  replace("L2-type-8", "The positions are integers.",
          arrayRecord(ScalarType::Int64, 3, zeros(96), Storage::Raw), "scalar type");
  replace("L2-type-5", "The positions are integers of 32 bits.",
          arrayRecord(ScalarType::UInt32, 3, zeros(48), Storage::Raw), "scalar type");
  replace("L2-type-6-not-named", "The positions are on a grid, which the file does not name.",
          arrayRecord(ScalarType::Int32, 3, zeros(48), Storage::Raw), "scalar type");
  replace("L2-4-components", "The positions have four numbers.",
          arrayRecord(ScalarType::Float64, 4, zeros(128), Storage::Raw), "components");
  replace("L2-2-components", "The positions have two numbers.",
          arrayRecord(ScalarType::Float64, 2, zeros(64), Storage::Raw), "components");
  replace("L2-1-component", "The positions have one number.",
          arrayRecord(ScalarType::Float64, 1, zeros(96), Storage::Raw), "components");

  // A simplex whose slab refers to an empty layer.
  const Base simple = plain();
  cases.add(
      "L3-no-rows", "A layer has no vertices.", simple,
      [](Image& image) {
        image = Image(headJson({}, {"simplex"}));
        const Slab slab = simplex()[0];
        image.addConnectivity("CONN 0", *slab.connectivity);
        image.addLayer("LAYR 0", 1, {});
        image.addSlab("SLAB 0", 0, slab, "CONN 0", "", "LAYR 0");
        image.addEnd();
      },
      "LAYR 0/positions/rows");
  cases.add(
      "L4-bytes-after", "Eight bytes follow the positions.", base,
      [](Image& image) { image.chunk("LAYR 0").payload.putBytes("extra", zeros(8)); },
      "LAYR 0/extra");
  cases.add(
      "L4-array-after", "A second array follows the positions.", base,
      [](Image& image) {
        image.chunk("LAYR 0").payload.add(
            "extra", arrayRecord(ScalarType::Float64, 1, zeros(32), Storage::Raw));
      },
      "LAYR 0/extra");
  cases.add(
      "L4-cut-off", "The payload ends within the time.", base,
      [](Image& image) {
        image.chunk("LAYR 0").payload.truncate(4);
        image.chunk("LAYR 0").payload.dropBlocks();
      },
      "LAYR 0/header/length");
  cases.add(
      "L4-attribute-missing", "An attribute is counted that is not there.", base,
      [](Image& image) { image.set("LAYR 0/attributes", 1U); }, "LAYR 0/attributes");
  cases.add(
      "L4-attributes-2-to-the-32-less-1", "2^32 - 1 attributes are counted.", base,
      [](Image& image) { image.set("LAYR 0/attributes", ~0U); }, "LAYR 0/attributes");
  const Base warm = withLayerAttributes();
  cases.add(
      "L4-attribute-not-counted", "An attribute follows that is not counted.", warm,
      [](Image& image) { image.set("LAYR 0/attributes", 1U); }, "LAYR 0/attributes");
  cases.add(
      "L5-cell-attribute", "An attribute of a LAYR is one of cells.", warm,
      [](Image& image) { image.set("LAYR 0/attribute 1/domain", std::uint8_t{2}); },
      "LAYR 0/attribute 1/domain");
  cases.add(
      "L5-of-no-cell", "The LAYRs of a slab have an attribute of cells, of no rows.", base,
      [](Image& image) {
        for (const std::string layer : {"LAYR 0", "LAYR 1"}) {
          image.chunk(layer).payload.add(
              "attribute 0",
              attributeRecord(model::makeAttribute<std::uint8_t>("b", Domain::Cell, {}),
                              Storage::Raw));
          image.set(layer + "/attributes", 1U);
        }
      },
      "LAYR 0/attribute 0/domain");
  for (const int byte : {0, 3}) {
    cases.add(
        fmt::format("L6-reserved-byte-{}", byte), "A reserved byte is not zero.", base,
        [&](Image& image) { image.setBytes("LAYR 0/reserved", "\x01", byte); }, "LAYR 0/reserved",
        byte);
  }
  cases.add(
      "L4-empty", "The payload has no bytes.", base,
      [](Image& image) { image.chunk("LAYR 0").payload.truncate(0); }, "LAYR 0/header/length");
}

void addPoseFaults(InvalidCases& cases) {
  const Base base = withPoses();
  const auto set = [&](const std::string& name, const std::string& fault, const std::string& field,
                       auto value) {
    cases.add(
        name, fault, base, [&](Image& image) { image.set("POSE 1/" + field, value); },
        "POSE 1/" + field);
  };
  for (const auto& [name, value] : kNotFinite) {
    set(fmt::format("K1-time-{}", name), fmt::format("The time is {}.", value), "time", value);
    for (const char* field : {"m00", "m03", "m22", "m23"}) {
      set(fmt::format("K3-{}-{}", field, name), fmt::format("{} is {}.", field, value), field,
          value);
    }
  }
  const auto layer = [&](const std::string& name, const std::string& fault,
                         std::uint64_t distance) {
    set("K2-" + name, "layer is " + fault + ".", "layer", distance);
  };
  const auto offsetOf = [&](const std::string& place) { return base.image.offset(place); };
  const auto to = [&](const std::string& place) {
    return offsetOf("POSE 1/header") - offsetOf(place);
  };
  layer("zero", "0", 0);
  layer("of-the-file-header", "the distance to the file header", offsetOf("POSE 1/header"));
  layer("of-head", "the distance to HEAD", to("HEAD/header"));
  layer("of-connectivity", "the distance to a CONN", to("CONN 0/header"));
  layer("of-slab", "the distance to a SLAB", to("SLAB 0/header"));
  layer("of-pose", "the distance to another POSE", to("POSE 0/header"));
  layer("of-payload", "the distance to the payload of a LAYR", to("LAYR 1"));
  layer("of-done", "the distance to DONE, which comes after it, modulo 2^64", to("DONE/header"));
  layer("offset", "the offset of a LAYR in the file", offsetOf("LAYR 1/header"));
  layer("2-to-the-32-more", "2^32 more than the distance to a LAYR",
        to("LAYR 1/header") + (std::uint64_t{1} << 32));
  layer("2-to-the-64-less-8", "2^64 - 8", kLargest - 7);
  cases.add(
      "K2-layer-after", "layer is the distance to a LAYR after the POSE, modulo 2^64.", base,
      [](Image& image) { image.move("LAYR 1", "SLAB 0"); }, "POSE 0/layer");
  cases.add(
      "K4-bytes-after", "Eight bytes follow the matrix.", base,
      [](Image& image) { image.chunk("POSE 0").payload.putBytes("extra", zeros(8)); },
      "POSE 0/extra");
  cases.add(
      "K4-cut-off", "The payload ends within the matrix.", base,
      [](Image& image) { image.chunk("POSE 0").payload.truncate(16 + 11 * 8); },
      "POSE 0/header/length");
  cases.add(
      "K4-empty", "The payload has no bytes.", withPoses(),
      [](Image& image) {
        Image::Chunk& pose = image.chunk("POSE 0");
        pose.payload = Record();
        pose.offsets.clear();
      },
      "POSE 0/header/length");
  cases.add(
      "K4-block", "It has a block.", base,
      [](Image& image) { image.chunk("POSE 0").payload.putBlock("extra", zeros(8)); },
      "POSE 0/extra");
  cases.add(
      "K5-not-named", "The file does not name the feature pose, which it uses.", base,
      [](Image& image) {
        Record head;
        head.putBytes("json", headJson({}, {"tetrahedron"}));
        image.chunk("HEAD").payload = head;
      },
      "POSE 0");
  // The last layer is a POSE, with 18 LAYRs before it.
  const Solid solid = cornerTetrahedron();
  std::vector<Pose> poses;
  for (int i = 0; i < 19; ++i) poses.push_back(pose(solid, i, {0, 0, 0}));
  const std::vector<Slab> still = sweep(solid, poses, {.capSlabs = false});
  const auto posedAfter = [&](const std::string& layer) {
    Image image(headJson({"pose"}, {"tetrahedron"}));
    image.addConnectivity("first", *still.front().connectivity);
    image.addConnectivity("step", *still[1].connectivity);
    image.addConnectivity("last", *still.back().connectivity);
    image.addLayer("LAYR 0", 0, still[0].lowerLayer());
    for (std::size_t i = 0; i < still.size(); ++i) {
      const bool isLast = i + 1 == still.size();
      const std::string upper = isLast ? "POSE 0" : fmt::format("LAYR {}", i + 1);
      if (isLast) {
        image.addPose(upper, still[i].timeEnd, model::Affine3x4::Identity(), layer);
      } else {
        image.addLayer(upper, still[i].timeEnd, still[i].upperLayer());
      }
      image.addSlab(fmt::format("SLAB {}", i), 0, still[i],
                    i == 0   ? "first"
                    : isLast ? "last"
                             : "step",
                    fmt::format("LAYR {}", i), upper);
    }
    image.addEnd();
    return image;
  };
  cases.add(
      "K6-layer-far-back", "layer names the last LAYR but 16.",
      {posedAfter("LAYR 2"), base.features}, [&](Image& image) { image = posedAfter("LAYR 1"); },
      "POSE 0/layer");
  cases.add(
      "O6-pose-not-named", "No slab names a POSE.", base,
      [](Image& image) {
        Image::Chunk copy = image.chunk("POSE 0");
        copy.name = "unused";
        image.add(copy, "SLAB 0");
      },
      "unused/header");
  cases.add(
      "S2-connectivity-of-pose", "connectivity is the distance to a POSE.", base,
      [&](Image& image) { image.chunk("SLAB 1").offsets["connectivity"] = "POSE 0"; },
      "SLAB 1/connectivity");
  cases.add(
      "P1-posed-too-few", "The LAYR of a POSE has 3 rows, CONN says 4.", base,
      [&](Image& image) {
        const std::vector<Point4> three(3, Point4(0, 0, 0, 0));
        image.chunk("LAYR 1").payload = layerRecord(1, three, {}, {}, Storage::Raw);
      },
      "LAYR 1/positions/rows");
  cases.add(
      "P2-posed", "A coordinate overflows where it is moved.", base,
      [](Image& image) {
        image.set("POSE 1/m00", 1.5e308);
        image.set("POSE 1/m03", 1.5e308);
      },
      "POSE 1/m00");
  cases.add(
      "P3-pose-later", "A POSE is later than end.", base,
      [](Image& image) { image.set("POSE 1/time", 3.0); }, "POSE 1/time");
}

void addSlabFaults(InvalidCases& cases) {
  const Base base = plain();
  const Base two = layered();
  Base annotated = plain();
  annotated.image.add(noteChunk(16), "SLAB 0");
  const auto set = [&](const std::string& name, const std::string& fault, const Base& of,
                       const std::string& place, auto value) {
    cases.add(
        name, fault, of, [&](Image& image) { image.set(place, value); }, place);
  };
  for (const auto& [name, value] : kNotFinite) {
    set(fmt::format("S1-begin-{}", name), fmt::format("begin is {}.", value), base, "SLAB 0/begin",
        value);
    set(fmt::format("S1-end-{}", name), fmt::format("end is {}.", value), base, "SLAB 0/end",
        value);
  }
  set("S1-begin-after-end", "begin is greater than end.", base, "SLAB 0/begin", 2.0);
  set("S1-begin-just-after-end", "begin is the next number after end.", base, "SLAB 0/begin",
      std::nextafter(1.0, 2.0));

  const auto offsetIn = [](const Base& of, const char* place) { return of.image.offset(place); };
  const auto part = [&](const std::string& rule, const std::string& field, const Base& of,
                        const std::string& slab, const std::string& name, const std::string& fault,
                        std::uint64_t distance) {
    set(fmt::format("{}-{}-{}", rule, field, name), field + " is " + fault + ".", of,
        slab + "/" + field, distance);
  };
  const auto connectivity = [&](const std::string& name, const std::string& fault,
                                std::uint64_t distance) {
    part("S2", "connectivity", two, "SLAB 1", name, fault, distance);
  };
  const std::uint64_t second = offsetIn(two, "SLAB 1/header");
  const auto to = [&](const char* place) { return second - offsetIn(two, place); };
  connectivity("zero", "0", 0);
  connectivity("of-the-file-header", "the distance to the file header", second);
  connectivity("of-head", "the distance to HEAD", to("HEAD/header"));
  connectivity("of-layer", "the distance to a LAYR", to("LAYR 0/header"));
  connectivity("of-slab", "the distance to a SLAB", to("SLAB 0/header"));
  connectivity("of-payload", "the distance to the payload of a CONN", to("CONN 1"));
  connectivity("off-by-one", "one more than the distance to a CONN", to("CONN 1/header") + 1);
  connectivity("of-done", "the distance to DONE, which comes after it, modulo 2^64",
               to("DONE/header"));
  connectivity("offset", "the offset of a CONN in the file", offsetIn(two, "CONN 1/header"));
  connectivity("2-to-the-32-more", "2^32 more than the distance to a CONN",
               to("CONN 1/header") + (std::uint64_t{1} << 32));
  connectivity("2-to-the-63", "2^63", std::uint64_t{1} << 63);
  connectivity("2-to-the-64-less-8", "2^64 - 8", kLargest - 7);
  part("S2", "connectivity", annotated, "SLAB 0", "of-optional-chunk",
       "the distance to an optional chunk",
       offsetIn(annotated, "SLAB 0/header") - offsetIn(annotated, "note/header"));
  cases.add(
      "S2-connectivity-after-slab", "connectivity names a CONN after the slab, modulo 2^64.", base,
      [](Image& image) { image.move("CONN 0", "DONE"); }, "SLAB 0/connectivity");

  // `lower` of the second slab is `upper` of the first.
  const std::uint64_t first = offsetIn(two, "SLAB 0/header");
  const auto layer = [&](const std::string& name, const std::string& fault,
                         std::uint64_t distance) {
    cases.add(
        "S3-layer-" + name, "upper is " + fault + "; lower of the next slab names the same.", two,
        [&](Image& image) {
          image.set("SLAB 0/upper", distance);
          image.set("SLAB 1/lower", distance + (second - first));
        },
        "SLAB 0/upper");
  };
  const auto toLayer = [&](const char* place) { return first - offsetIn(two, place); };
  layer("of-the-file-header", "the distance to the file header", first);
  layer("of-head", "the distance to HEAD", toLayer("HEAD/header"));
  layer("of-connectivity", "the distance to a CONN", toLayer("CONN 0/header"));
  layer("of-payload", "the distance to the payload of a LAYR", toLayer("LAYR 0"));
  layer("off-by-one", "one more than the distance to a LAYR", toLayer("LAYR 0/header") + 1);
  layer("of-done", "the distance to DONE, which comes after it, modulo 2^64",
        toLayer("DONE/header"));
  layer("offset", "the offset of a LAYR in the file", offsetIn(two, "LAYR 0/header"));
  layer("1", "1", 1);
  layer("2-to-the-32-more", "2^32 more than the distance to a LAYR",
        toLayer("LAYR 0/header") + (std::uint64_t{1} << 32));
  layer("2-to-the-63", "2^63", std::uint64_t{1} << 63);
  layer("2-to-the-64-less-24", "2^64 - 24", kLargest - 23);
  cases.add(
      "S3-layer-after-slab", "upper names a LAYR after the slab, modulo 2^64.", two,
      [](Image& image) { image.move("LAYR 0", "CONN 1"); }, "SLAB 0/upper");
  part("S3", "lower", between(), "SLAB 0", "of-first-slab-2-to-the-64-less-1", "2^64 - 1",
       kLargest);

  set("S4-body-1-of-1", "The slab is of body 1, of 1.", base, "SLAB 0/body", 1U);
  set("S4-body-1-of-1-no-index", "The slab is of body 1, of 1.", unindexed(), "SLAB 0/body", 1U);
  set("S4-body-2-to-the-32-less-1", "The slab is of body 2^32 - 1.", base, "SLAB 0/body", ~0U);

  const auto replace = [&](const std::string& name, const std::string& fault,
                           const std::string& array, const Record& record,
                           const std::string& field) {
    cases.add(
        name, fault, base,
        [&](Image& image) { image.chunk("SLAB 0").payload.replace(array, record); },
        "SLAB 0/" + array + "/" + field);
  };
  replace("S5-type-7", "The interior positions are integers.", "interior positions",
          arrayRecord(ScalarType::UInt64, 3, zeros(120), Storage::Raw), "scalar type");
  replace("S5-type-6-not-named", "The positions are on a grid, which the file does not name.",
          "interior positions", arrayRecord(ScalarType::Int32, 3, zeros(60), Storage::Raw),
          "scalar type");
  replace("S5-4-components", "The interior positions have four numbers.", "interior positions",
          arrayRecord(ScalarType::Float64, 4, zeros(160), Storage::Raw), "components");
  replace("S5-1-component", "The interior positions have one number.", "interior positions",
          arrayRecord(ScalarType::Float64, 1, zeros(120), Storage::Raw), "components");
  replace("S6-binary32", "The interior times are of binary32.", "interior times",
          arrayRecord(ScalarType::Float32, 1, zeros(20), Storage::Raw), "scalar type");
  replace("S6-integers", "The interior times are integers.", "interior times",
          arrayRecord(ScalarType::Int64, 1, zeros(40), Storage::Raw), "scalar type");
  replace("S6-3-components", "The interior times have three numbers.", "interior times",
          arrayRecord(ScalarType::Float64, 3, zeros(120), Storage::Raw), "components");
  replace("S6-a-time-too-few", "Five interior positions have four times.", "interior times",
          arrayRecord(ScalarType::Float64, 1, zeros(32), Storage::Raw), "rows");
  replace("S6-a-time-too-many", "Five interior positions have six times.", "interior times",
          arrayRecord(ScalarType::Float64, 1, zeros(48), Storage::Raw), "rows");
  replace("S6-no-times", "Five interior positions have no times.", "interior times",
          arrayRecord(ScalarType::Float64, 1, "", Storage::Raw), "rows");

  const auto another = [&](const std::string& name, const std::string& fault,
                           const std::function<void(Image&)>& change) {
    cases.add(
        name, fault, two,
        [&](Image& image) {
          Image::Chunk copy = image.chunk("LAYR 0");
          copy.name = "LAYR 1";
          image.add(copy, "SLAB 1");
          image.chunk("SLAB 1").offsets["lower"] = "LAYR 1";
          change(image);
        },
        "SLAB 1/lower");
  };
  another("S7-layer-differs-by-a-bit", "lower is another LAYR, a bit of a coordinate differs.",
          [](Image& image) { image.flip("LAYR 1/positions/stored", 8); });
  another("S7-layer-stored-otherwise", "lower is another LAYR: the same vertices, compressed.",
          [](Image& image) {
            Record head;
            head.putBytes("json", headJson({"zstd"}, {"cross"}));
            image.chunk("HEAD").payload = head;
            image.chunk("LAYR 1").payload =
                layerRecord(0, crossPolytope()[0].upperLayer(), {}, {}, Storage::Library);
          });
  cases.add(
      "S7-copy-of-pose", "lower is another POSE of the same LAYR.", withPoses(),
      [](Image& image) {
        Image::Chunk copy = image.chunk("POSE 0");
        copy.name = "copy";
        image.add(copy, "SLAB 1");
        image.chunk("SLAB 1").offsets["lower"] = "copy";
      },
      "SLAB 1/lower");
  const std::vector<Slab> cross = crossPolytope();
  cases.add(
      "S7-layer-left-open", "lower is 0 where the slab before has an upper layer.", two,
      [&](Image& image) {
        image = Image::of({{"cross", {cross[0], simplex()[0]}}});
        image.chunk("SLAB 1").offsets.erase("lower");
      },
      "SLAB 1/lower");
  cases.add(
      "S7-layer-from-nowhere", "lower is a LAYR where the slab before has no upper layer.",
      baseOf({{"simplex", {simplex(1, {0, 0, 0, -1})[0], simplex()[0]}}}),
      [](Image& image) {
        image = Image(headJson({}, {"simplex"}));
        const Slab first = simplex(1, {0, 0, 0, -1})[0];
        const Slab second = upperHalf();
        image.addConnectivity("CONN 0", *first.connectivity);
        image.addSlab("SLAB 0", 0, first, "CONN 0", "", "");
        image.addConnectivity("CONN 1", *second.connectivity);
        image.addLayer("LAYR 0", 0, second.lowerLayer());
        image.addSlab("SLAB 1", 0, second, "CONN 1", "LAYR 0", "");
        image.addEnd();
      },
      "SLAB 1/lower");
  std::vector<Slab> moved = cross;
  for (Slab& slab : moved) {
    for (Point4& vertex : slab.vertices) vertex.x() += 5;
  }
  const Base bodies = baseOf({{"one", cross}, {"two", moved}});
  cases.add(
      "S7-layer-of-other-body", "lower is the upper layer of another body's slab.", bodies,
      [](Image& image) { image.chunk("SLAB 3").offsets["lower"] = "LAYR 0"; }, "SLAB 3/lower");

  const auto follow = [&](const std::string& name, const std::string& fault, double begin) {
    cases.add(
        name, fault, baseOf({{"simplex", {simplex()[0], simplex(1, {0, 0, 0, 1})[0]}}}),
        [&](Image& image) {
          Slab second = simplex(1, {0, 0, 0, 1})[0];
          second.timeBegin = begin;
          image = Image::of({{"simplex", {simplex()[0], second}}});
        },
        "SLAB 1/begin");
  };
  follow("S8-overlap", "The second slab begins before the first ends.", 0.5);
  follow("S8-overlap-by-a-bit", "The second slab begins one number before the first ends.",
         std::nextafter(1.0, 0.0));
  cases.add(
      "S8-backwards", "The second slab lies before the first.",
      baseOf({{"simplex", {simplex()[0], simplex(1, {0, 0, 0, 2})[0]}}}),
      [](Image& image) {
        image = Image::of({{"simplex", {simplex(1, {0, 0, 0, 2})[0], simplex()[0]}}});
      },
      "SLAB 1/begin");
  set("S8-gap-over-layer", "The slab above a layer begins later than the one below ends.", two,
      "SLAB 1/begin", 0.25);
  cases.add(
      "S8-in-second-body", "A slab of the second body begins before the one before ends.",
      baseOf({{"one", {simplex()[0], simplex(1, {0, 0, 0, 1})[0]}},
              {"two", {simplex()[0], simplex(1, {0, 0, 0, 1})[0]}}}),
      [](Image& image) {
        image = Image::of({{"one", {simplex()[0], simplex(1, {0, 0, 0, 1})[0]}},
                           {"two", {simplex()[0], simplex(1, {0, 0, 0, 0.5})[0]}}});
      },
      "SLAB 3/begin");
  // One of 17 CONNs, or layers, is not among the last 16.
  std::vector<Slab> row;
  for (int i = 0; i < 18; ++i) row.push_back(simplex(1, {0, 0, 0, double(i)})[0]);
  for (Slab& slab : row) {
    slab.connectivity = std::make_shared<Connectivity>(*slab.connectivity);
  }
  row.back().connectivity = row[1].connectivity;
  const auto connectivityOf = [](Image image, const std::string& last) {
    image.remove("CONN 17");
    image.chunk("SLAB 17").offsets["connectivity"] = last;
    return image;
  };
  Base manyParts = baseOf({{"simplex", row}});
  const Image all = manyParts.image;
  manyParts.image = connectivityOf(all, "CONN 1");
  cases.add(
      "S12-connectivity", "connectivity names the last CONN but 16.", manyParts,
      [&](Image& image) { image = connectivityOf(all, "CONN 0"); }, "SLAB 17/connectivity");
  std::vector<Pose> poses;
  for (int i = 0; i < 17; ++i) poses.push_back(pose(cube(), i, {0, 0, 0}));
  const Base rising = baseOf({{"cube", sweep(cube(), poses)}});
  cases.add(
      "S12-layer", "upper names the last LAYR but 16.", rising,
      [](Image& image) {
        for (int i = 1; i <= 16; ++i) image.move(fmt::format("LAYR {}", i), "SLAB 0");
      },
      "SLAB 0/upper");
  Base copied = rising;
  Image::Chunk copy = copied.image.chunk("LAYR 16");
  copy.name = "copy";
  copied.image.add(copy, "SLAB 17");
  copied.image.chunk("SLAB 17").offsets["lower"] = "copy";
  cases.add(
      "S12-copy", "lower names a copy of the layer, the last LAYR but 16.", copied,
      [](Image& image) { image.move("copy", "LAYR 1"); }, "SLAB 17/lower");
  cases.add(
      "S9-bytes-after", "Eight bytes follow the last part of the payload.", base,
      [](Image& image) { image.chunk("SLAB 0").payload.putBytes("extra", zeros(8)); },
      "SLAB 0/extra");
  set("S9-attribute-missing", "An attribute is counted that is not there.", base,
      "SLAB 0/attributes", 1U);
  set("S9-attributes-2-to-the-32-less-1", "2^32 - 1 attributes are counted.", base,
      "SLAB 0/attributes", ~0U);
  cases.add(
      "S9-attribute-not-counted", "An attribute follows that is not counted.",
      baseOf({{"simplex",
               [] {
                 std::vector<Slab> slabs = simplex();
                 slabs[0].attributes = {
                     model::makeAttribute<float>("a", Domain::Vertex, {1, 2, 3, 4, 5})};
                 return slabs;
               }()}}),
      [](Image& image) { image.set("SLAB 0/attributes", 0U); }, "SLAB 0/attributes");
  // INDX repeats the fields, so the slab must have them; the array after them is cut off.
  cases.add(
      "S9-block-left", "A block belongs to no array.", base,
      [](Image& image) { image.chunk("SLAB 0").payload.putBlock("extra", zeros(8)); },
      "SLAB 0/extra");
  std::string ofSimplex;
  for (const double corner : {0.0, 1.0}) {
    for (int axis = 0; axis < 4; ++axis) ofSimplex += bytesOf(corner);
  }
  cases.add(
      "S10-bounds-of-one-block", "Bounds are there, right, of one block of cells.", base,
      [&](Image& image) {
        Record& payload = image.chunk("SLAB 0").payload;
        payload = withCounted(payload, "bounds", 1, ofSimplex,
                              {"begin", "end", "connectivity", "lower", "upper", "body",
                               "attributes", "bounds", "reserved"},
                              {"interior positions", "interior times"});
      },
      "SLAB 0/bounds");
  set("S9-bounds-missing", "Bounds are counted that are not there.", base, "SLAB 0/bounds", 1U);
  const Base blocks = baseOf({{"simplices", {manySimplices()}}}, {.storage = Storage::Repeats});
  for (const auto& [name, at] :
       {std::pair<const char*, std::size_t>{"minimum", 16}, {"maximum", 56}}) {
    cases.add(
        fmt::format("S10-{}-of-a-block", name), fmt::format("The {} of a block is another.", name),
        blocks, [&, at = at](Image& image) { image.setBytes("SLAB 0/bounds 1", bytesOf(0.5), at); },
        "SLAB 0/bounds 1", at);
    // The block is read here, whichever of its bounds is believed.
    cases.refusedAt(name == std::string_view("minimum") ? 0.75 : 0.25);
  }
  set("S9-bounds-2-to-the-32-less-1", "2^32 - 1 bounds are counted.", base, "SLAB 0/bounds", ~0U);
  for (const int byte : {0, 3}) {
    cases.add(
        fmt::format("S11-reserved-byte-{}", byte), "A reserved byte is not zero.", base,
        [&](Image& image) { image.setBytes("SLAB 0/reserved", "\x01", byte); }, "SLAB 0/reserved",
        byte);
  }
  cases.add(
      "S9-cut-off", "The payload ends with its fixed part.", base,
      [](Image& image) { image.chunk("SLAB 0").payload.truncate(56); }, "SLAB 0/header/length");
}

namespace {

/// Adds faults in the attributes of vertices that parts of a slab have.
void addAttributesOfPartsFaults(InvalidCases& cases) {
  const Base base = withLayerAttributes();
  const auto other = [&](const std::string& name, const std::string& fault,
                         const std::string& place, auto value) {
    cases.add(
        "P5-" + name, fault, base, [&](Image& image) { image.set(place, value); }, place);
  };
  const std::string layer = "LAYR 0/attribute 0/";
  other("other-name", "Layer and interior have attributes of different names.", layer + "name",
        'x');
  other("other-name-above", "A slab has a vertex attribute of another name than its lower layer.",
        "SLAB 1/attribute 0/name", 'x');
  other("other-type", "Layer and interior have attributes of different types.",
        layer + "values/scalar type", std::uint8_t{2});
  cases.add(
      "P5-other-components", "Layer and interior have rows of different lengths.", base,
      [&](Image& image) {
        image.chunk("LAYR 0").payload.replace(
            "attribute 0/values", arrayRecord(ScalarType::UInt8, 2, zeros(12), Storage::Raw));
      },
      layer + "values/components");
  cases.add(
      "P5-other-order", "Layer and interior have the same attributes in another order.", base,
      [&](Image& image) {
        Record& payload = image.chunk("LAYR 0").payload;
        const Record first = payload.part("attribute 0");
        payload.replace("attribute 0", payload.part("attribute 1"));
        payload.replace("attribute 1", first);
      },
      layer + "name");
  const auto without = [&](const std::string& name, const std::string& fault,
                           const std::string& chunk, const Record& payload) {
    cases.add(
        "P5-" + name, fault, base, [&](Image& image) { image.chunk(chunk).payload = payload; },
        chunk + "/attributes");
  };
  const std::vector<Slab> cross = crossPolytope();
  without("layer-has-none", "The interior has attributes, a layer has none.", "LAYR 0",
          layerRecord(0, cross[0].upperLayer(), {}, {}, Storage::Raw));
  cases.add(
      "P5-interior-has-none", "The lower layer has attributes, the interior has none.", base,
      [&](Image& image) {
        Image::Chunk& slab = image.chunk("SLAB 1");
        slab.payload =
            slabRecord({0, 1}, 0, {}, std::span(cross[1].vertices).last(1), {}, {}, Storage::Raw);
      },
      "SLAB 1/attributes");
  // A slab between two layers, whose chunk has an attribute of no vertex.
  cases.add(
      "P5-no-interior", "A SLAB without interior vertices has an attribute of vertices.", between(),
      [](Image& image) {
        Record& payload = image.chunk("SLAB 0").payload;
        payload.add("attribute 0",
                    attributeRecord(model::makeAttribute<std::uint8_t>("a", Domain::Vertex, {}),
                                    Storage::Raw));
        image.set("SLAB 0/attributes", 1U);
      },
      "SLAB 0/attributes");
}

}  // namespace

void addAssemblyFaults(InvalidCases& cases) {
  const Base base = between();
  const Solid solid = cornerTetrahedron();
  const std::vector<Slab> slabs =
      sweep(solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 0})}, {.capSlabs = false});
  // Rows are added or removed at the position of a corner, so the bounds stay the same.
  const auto layer = [&](const std::string& name, const std::string& fault, const char* chunk,
                         double time, std::size_t rows) {
    cases.add(
        name, fault, base,
        [&](Image& image) {
          std::vector<Point4> vertices(slabs[0].vertices.begin(), slabs[0].vertices.begin() + 4);
          vertices.resize(rows, Point4(0, 0, 0, time));
          image.chunk(chunk).payload = layerRecord(time, vertices, {}, {}, Storage::Raw);
        },
        std::string(chunk) + "/positions/rows");
  };
  layer("P1-lower-too-few", "The lower LAYR has 3 rows, CONN says 4.", "LAYR 0", 0, 3);
  layer("P1-lower-too-many", "The lower LAYR has 5 rows, CONN says 4.", "LAYR 0", 0, 5);
  layer("P1-upper-too-few", "The upper LAYR has 3 rows, CONN says 4.", "LAYR 1", 1, 3);
  layer("P1-upper-too-many", "The upper LAYR has 5 rows, CONN says 4.", "LAYR 1", 1, 5);
  cases.add(
      "P1-interior-too-many", "Two interior vertices are stored, CONN says none.", base,
      [](Image& image) { storeInterior(image, std::vector<Point4>(2, Point4(0, 0, 0, 0))); },
      "SLAB 0/interior positions/rows");
  const Base simple = plain();
  cases.add(
      "P1-interior-too-few", "Four interior vertices are stored, CONN says five.", simple,
      [](Image& image) { storeInterior(image, std::span(simplex()[0].vertices).first(4)); },
      "SLAB 0/interior positions/rows");
  cases.add(
      "P1-no-lower-layer", "lower is 0, CONN says 4.", base,
      [](Image& image) {
        image.chunk("SLAB 0").offsets.erase("lower");
        image.remove("LAYR 0");
      },
      "SLAB 0/lower");
  cases.add(
      "P1-means-stored", "The means are stored among the interior vertices.", withMeans(),
      [](Image& image) { storeInterior(image, meansSlab().vertices); },
      "SLAB 0/interior positions/rows");

  const std::string positions = "SLAB 0/interior positions/stored";
  for (const auto& [name, value] : kNotFinite) {
    // These do not affect the sums: DONE keeps the bounds of the other vertices.
    const auto set = [&, name = name, value = value](const std::string& where, const Base& of,
                                                     const std::string& place, std::size_t at,
                                                     const std::string& bytes) {
      cases.add(
          fmt::format("P2-{}-{}", where, name), fmt::format("A coordinate is {}.", value), of,
          [&](Image& image) { image.setBytes(place, bytes, at); }, place, at);
    };
    set("interior", simple, positions, 8 * 13, bytesOf(value));
    set("layer", base, "LAYR 0/positions/stored", 8 * 5, bytesOf(value));
    set("time", simple, "SLAB 0/interior times/stored", 8 * 2, bytesOf(value));
    set("binary32", baseOf({{"simplex", simplex()}}, {.float32 = true}), positions, 4 * 3,
        bytesOf(static_cast<float>(value)));
  }
  const auto meanOf = [](double x, double time) {
    Slab slab = simplex(1, {0, 0, 0, 0})[0];
    auto connectivity = std::make_shared<Connectivity>(*slab.connectivity);
    connectivity->vertexCount = 9;
    connectivity->means.add(std::vector<std::uint32_t>{5, 6, 7});
    slab.connectivity = connectivity;
    for (int i = 0; i < 3; ++i) slab.vertices.emplace_back(x, 0, 0, time);
    slab.vertices.resize(9, Point4(0, 0, 0, 0));
    return slab;
  };
  cases.add(
      "P2-mean-overflows", "The sum of three coordinates of 10^308 is infinite.",
      baseOf({{"simplex", {meanOf(1e307, 0)}}}),
      [&](Image& image) {
        image = Image::of({{"simplex", {meanOf(1e308, 0)}}});
      },
      "CONN 0/mean sources/stored");

  const auto setTime = [&](const std::string& name, const std::string& fault, const char* place,
                           double time) {
    cases.add(
        name, fault, base, [&](Image& image) { image.set(place, time); }, place);
  };
  setTime("P3-lower-later", "The lower LAYR is later than begin.", "LAYR 0/time", 0.5);
  setTime("P3-lower-earlier", "The lower LAYR is earlier than begin.", "LAYR 0/time", -1);
  setTime("P3-lower-at-end", "The lower LAYR is at the time of the upper.", "LAYR 0/time", 1);
  setTime("P3-upper-earlier", "The upper LAYR is earlier than end.", "LAYR 1/time",
          std::nextafter(1.0, 0.0));
  setTime("P3-upper-later", "The upper LAYR is later than end.", "LAYR 1/time", 2);
  setTime("P3-begin-earlier", "begin is earlier than the lower LAYR.", "SLAB 0/begin", -1);
  cases.add(
      "P3-layer-between-slabs", "A layer is at another time than end below and begin above.",
      layered(), [](Image& image) { image.set("LAYR 0/time", -0.25); }, "LAYR 0/time");

  const auto interior = [&](const std::string& name, const std::string& fault, double time) {
    cases.add(
        name, fault, simple,
        [&](Image& image) { image.setBytes("SLAB 0/interior times/stored", bytesOf(time), 24); },
        "SLAB 0/interior times/stored", 24);
  };
  interior("P4-before-begin", "An interior vertex lies before begin.", -0.5);
  interior("P4-after-end", "An interior vertex lies after end.", 1.5);
  interior("P4-just-after-end", "An interior vertex lies one number after end.",
           std::nextafter(1.0, 2.0));
  interior("P4-just-before-begin", "An interior vertex lies one number before begin.",
           -std::numeric_limits<double>::denorm_min());
  const auto flat = [&](double time) {
    Slab slab = meanOf(0.5, time);
    auto connectivity = std::make_shared<Connectivity>(*slab.connectivity);
    connectivity->cells.clear();
    slab.connectivity = connectivity;
    for (Point4& vertex : slab.vertices) vertex[3] = time;
    slab.timeBegin = slab.timeEnd = time;
    return Image::of({{"flat", {slab}}});
  };
  cases.add(
      "P4-mean-rounded-out",
      "The mean of three times 0.1 is the next number but one after it, where the slab ends.",
      {flat(0.125), {"means", "index"}}, [&](Image& image) { image = flat(0.1); },
      "CONN 0/mean sources/stored");
  addAttributesOfPartsFaults(cases);
}

}  // namespace t4d::conformance
