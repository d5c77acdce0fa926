#include "measure/body_contacts.h"

#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "measure/woven_noise.h"

/// Contacts between the bodies of meshes of labels.
namespace t4d::measure {
namespace {

using model::Point3;

/// The label of a lattice point at the time of a frame; 0 is none.
using LabelAt = std::function<int(const Point3& point, double time)>;

struct Labelled {
  std::vector<model::Mesh> meshes;
  std::vector<model::Body> bodies;
};

Labelled wovenLabelled(const LabelAt& labelAt, int labels, double size, int frames) {
  Labelled made;
  made.meshes.resize(static_cast<std::size_t>(labels));
  for (int label = 1; label <= labels; ++label) {
    const auto field = [&](const Point3& point, double time) {
      return labelAt(point, time) == label ? -1.0 : 1.0;
    };
    made.meshes[static_cast<std::size_t>(label - 1)] =
        woven(field, boxOf(size), 0, frames, frames, 1, /*mask=*/true);
  }
  for (const model::Mesh& mesh : made.meshes) {
    made.bodies.push_back({std::to_string(made.bodies.size() + 1), &mesh});
  }
  return made;
}

std::vector<BodyContact> contactsAmong(const Labelled& labelled, const TrackOptions& options = {}) {
  auto found = contactsOf(labelled.bodies, options);
  EXPECT_TRUE(found) << found.error().text();
  return found ? *found : std::vector<BodyContact>();
}

bool isIn(const Point3& point, double low, double high) {
  return point.minCoeff() >= low && point.maxCoeff() <= high;
}

/// The halves of a box of n points along each edge, side by side: their surfaces share the square
/// between the points next to its rim.
TEST(BodyContacts, OfTwoHalvesHaveTheSquareBetweenThem) {
  for (const int n : {4, 8}) {
    const auto halves = [=](const Point3& point, double) {
      if (!isIn(point, 2, n + 1)) return 0;
      return point.x() < 2 + n / 2 ? 1 : 2;
    };
    const auto contacts = contactsAmong(wovenLabelled(halves, 2, n + 3, 4));
    ASSERT_EQ(contacts.size(), 1U);
    EXPECT_EQ(contacts[0].body, 0U);
    EXPECT_EQ(contacts[0].other, 1U);
    EXPECT_EQ(contacts[0].begin, 0);
    EXPECT_EQ(contacts[0].end, 4);
    ASSERT_EQ(contacts[0].samples.size(), 5U);
    for (const ContactSample& sample : contacts[0].samples) {
      EXPECT_NEAR(sample.area, (n - 1) * (n - 1), 1e-9) << sample.time;
    }
    EXPECT_NEAR(contacts[0].largestArea, (n - 1) * (n - 1), 1e-9);
  }
}

/// The second box comes to the first, stays for two frames and leaves.
TEST(BodyContacts, LastFromTheFirstFrameOfTouchToTheLast) {
  const auto boxes = [](const Point3& point, double time) {
    if (isIn(point, 1, 4)) return 1;
    const double gap = time == 3 || time == 4 ? 0 : 2;
    return isIn(point - Point3(4 + gap, 0, 0), 1, 4) ? 2 : 0;
  };
  const auto contacts = contactsAmong(wovenLabelled(boxes, 2, 12, 7));
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_GT(contacts[0].begin, 2);
  EXPECT_LE(contacts[0].begin, 3);
  EXPECT_GE(contacts[0].end, 4);
  EXPECT_LT(contacts[0].end, 5);
  ASSERT_EQ(contacts[0].samples.size(), 2U);
  EXPECT_NEAR(contacts[0].samples[0].area, 9, 1e-9);
  EXPECT_EQ(contacts[0].samples[1].time, 4);
}

TEST(BodyContacts, AreNotBrokenWhereTheBorderMoves) {
  // A wall between two labels goes one voxel a frame through a box.
  const auto moving = [](const Point3& point, double time) {
    if (!isIn(point, 1, 8)) return 0;
    return point.x() < 3 + time ? 1 : 2;
  };
  const auto contacts = contactsAmong(wovenLabelled(moving, 2, 10, 4));
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].begin, 0);
  EXPECT_EQ(contacts[0].end, 4);
  for (const ContactSample& sample : contacts[0].samples) EXPECT_NEAR(sample.area, 49, 1e-9);
}

TEST(BodyContacts, OfBodiesApartAreNone) {
  const auto apart = [](const Point3& point, double) {
    return isIn(point, 1, 3) ? 1 : isIn(point, 5, 7) ? 2 : 0;
  };
  EXPECT_TRUE(contactsAmong(wovenLabelled(apart, 2, 8, 3)).empty());
}

std::string textOf(const std::vector<BodyContact>& contacts) {
  std::string text;
  for (const BodyContact& one : contacts) {
    text +=
        fmt::format("{} {} {} {} {}\n", one.body, one.other, one.begin, one.end, one.largestArea);
    for (const auto& [time, area] : one.samples) text += fmt::format("  {} {}\n", time, area);
  }
  return text;
}

TEST(BodyContacts, OfPartsJoinToThoseOfTheWhole) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const auto random = [=](const Point3& point, double time) {
      return static_cast<int>(std::floor(2 * (noise(seed, point, time) + 1)));
    };
    const Labelled labelled = wovenLabelled(random, 3, 4, 5);
    TrackOptions sparse;
    sparse.layers = false;
    sparse.times = {0.5, 2, 2.25};
    for (const TrackOptions& options : {TrackOptions(), sparse}) {
      const std::string whole = textOf(contactsAmong(labelled, options));
      EXPECT_FALSE(whole.empty());
      const std::uint64_t spans = contactSpanCount(labelled.bodies);
      for (const std::uint64_t count : {std::uint64_t{2}, std::uint64_t{3}, spans}) {
        std::vector<BodyContact> all;
        for (std::uint64_t k = 1; k <= count; ++k) {
          const auto part = contactsOf(labelled.bodies, options, model::Part{k, count}.of(spans));
          ASSERT_TRUE(part);
          all.insert(all.end(), part->begin(), part->end());
        }
        EXPECT_EQ(textOf(joinedContacts(std::move(all))), whole);
      }
    }
  }
}

}  // namespace
}  // namespace t4d::measure
