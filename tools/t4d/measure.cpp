#include "tools/t4d/measure.h"

#include <algorithm>
#include <filesystem>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/output_file.h"
#include "model/parallel.h"
#include "t4d/mesh.h"
#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/csv_field.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/frame_times.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/table_output.h"
#include "tools/t4d/wall.h"

namespace t4d::tools {
namespace {

constexpr std::uint64_t kDefaultMeasures = 60;

/// A row of the table; `before` and `behind` are fields with their commas.
std::string rowOf(const measure::SolidMeasures& sample, const WallMeasures& walls,
                  const std::string& before, const std::string& behind) {
  const bool any = !sample.bounds.empty();
  const auto place = [&](const model::Point3& point) {
    return any ? fmt::format("{},{},{}", point.x(), point.y(), point.z()) : std::string(",,");
  };
  std::string extra;
  if (walls.thickness) extra += fmt::format(",{}", *walls.thickness);
  if (walls.normalSpeed) extra += fmt::format(",{}", *walls.normalSpeed);
  return fmt::format("{}{},{},{},{},{},{},{},{},{}{}{}\n", sample.time, before, sample.volume,
                     sample.area, place(sample.centroid), sample.components, sample.genus,
                     sample.cavities, place(sample.bounds.min), place(sample.bounds.max), extra,
                     behind);
}

/// Walls of each body at each time. Those of a body that does not exist at a time are 0.
Result<std::vector<std::vector<WallMeasures>>> wallsOfEach(std::span<const model::Body> bodies,
                                                           std::span<const double> times,
                                                           const MeasureOptions& options,
                                                           const model::Progress& progress) {
  const auto motion = options.normalSpeed ? slice::WithMotion::Yes : slice::WithMotion::No;
  std::vector<std::unique_ptr<slice::TimeSlicer>> slicers;
  for (const model::Body& body : bodies) {
    slicers.push_back(std::make_unique<slice::TimeSlicer>(*body.source, motion));
  }
  const auto at = [&](std::size_t body, double time) -> Result<WallMeasures> {
    slice::Slice slice;
    slice.motion.emplace();
    if (model::timeWithin(*bodies[body].source, time)) {
      auto made = slicers[body]->at(time);
      if (!made) return made.error();
      slice = std::move(*made);
    }
    WallMeasures walls;
    if (options.thickness) walls.thickness = wallThickness(slice.mesh);
    if (options.normalSpeed) walls.normalSpeed = meanNormalSpeed(slice);
    return walls;
  };
  std::vector<std::vector<WallMeasures>> walls(bodies.size());
  const std::size_t count = bodies.size() * times.size();
  std::size_t done = 0;
  Result<void> outcome;
  using Item = std::shared_ptr<const Result<WallMeasures>>;
  model::inOrder<Item>(
      count,
      [&](std::size_t i) {
        return std::make_shared<const Result<WallMeasures>>(
            at(i / times.size(), times[i % times.size()]));
      },
      [&](const Item& made) {
        if (!*made) {
          outcome = made->error();
          return false;
        }
        walls[done / times.size()].push_back(**made);
        outcome = model::report(progress, ++done, count);
        return outcome.has_value();
      });
  if (!outcome) return outcome.error();
  return walls;
}

/// The measures of all bodies together, at each time: the mean over the area of all.
std::vector<WallMeasures> togetherOf(const std::vector<std::vector<WallMeasures>>& walls,
                                     const std::vector<std::vector<measure::SolidMeasures>>& each) {
  std::vector<WallMeasures> together(each.front().size());
  for (std::size_t i = 0; i < together.size(); ++i) {
    for (auto member : {&WallMeasures::thickness, &WallMeasures::normalSpeed}) {
      double sum = 0;
      double area = 0;
      for (std::size_t b = 0; b < each.size(); ++b) {
        if (!(walls[b][i].*member)) break;
        sum += each[b][i].area * *(walls[b][i].*member);
        area += each[b][i].area;
      }
      if (walls.front()[i].*member) together[i].*member = area > 0 ? sum / area : 0;
    }
  }
  return together;
}

/// Adds the measures of a solid at a time.
void addSolidMeasures(Members& members, const measure::SolidMeasures& solid,
                      const WallMeasures& walls) {
  const auto place = [&](const model::Point3& point) {
    return solid.bounds.empty() ? std::nullopt : std::optional(point);
  };
  members("volume", solid.volume, "In length units cubed.");
  members("area", solid.area, "Of the surface, in length units squared.").atLeast(0);
  members("centroid", place(solid.centroid), "x, y and z; null where there is no solid.");
  members("components", solid.components, "Connected surfaces that face outward.");
  members("cavities", solid.cavities, "Connected surfaces that face inward.");
  members("genus", solid.genus,
          "Sum over all surfaces: the number of handles, less 1/2 for every vertex at which a "
          "surface touches itself.");
  members("min", place(solid.bounds.min), "The least x, y and z; null where there is no solid.");
  members("max", place(solid.bounds.max), "The greatest x, y and z; null where there is no solid.");
  members
      .ifKnown(
          "wall_thickness", walls.thickness,
          "With --thickness: mean length of the normal inside the solid, in length units; 0 where "
          "there is no solid.")
      .atLeast(0);
  members
      .ifKnown(
          "normal_speed", walls.normalSpeed,
          "With --normal-speed: mean speed of the surface along its normal, inward or outward, in "
          "length units per time unit; 0 where there is no solid.")
      .atLeast(0);
}

/// A body, or all of them, at a time.
struct Sample {
  std::string name;  ///< of the body
  measure::SolidMeasures solid;
  WallMeasures walls;
  std::vector<Sample> bodies;  ///< each of several
};

std::vector<Sample> samplesOf(const MeasureReport& report) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < report.samples.size(); ++i) {
    Sample all = {{}, report.samples[i], report.walls[i], {}};
    for (const BodyMeasures& body : report.bodies) {
      all.bodies.push_back({body.name, body.samples[i], body.walls[i], {}});
    }
    samples.push_back(std::move(all));
  }
  return samples;
}

}  // namespace

Result<MeasureReport> measure(const Input& input, const MeasureOptions& options,
                              Observer& observer) {
  std::vector<double> times = options.times;
  if (times.empty()) times = model::evenTimes(model::timeSpanOf(input.bodies), kDefaultMeasures);
  const model::PartRange range = options.part.of(times.size());
  const auto share = std::span(times).subspan(range.begin, range.end - range.begin);
  const auto stage = observer.stage("measuring", share.size(), "times");
  auto each = measure::measuresOfEach(input.bodies, share, stage->callback());
  if (!each) return inInput(each.error(), input);
  std::vector<std::vector<WallMeasures>> walls(each->size(),
                                               std::vector<WallMeasures>(share.size()));
  if (options.thickness || options.normalSpeed) {
    const auto next =
        observer.stage("measuring walls", input.bodies.size() * share.size(), "times");
    auto made = wallsOfEach(input.bodies, share, options, next->callback());
    if (!made) return inInput(made.error(), input);
    walls = std::move(*made);
  }
  MeasureReport report{measure::addedUp(*each),
                       togetherOf(walls, *each),
                       {},
                       input.metadata.lengthUnit,
                       input.metadata.timeUnit};
  for (std::size_t b = 0; options.eachBody && each->size() > 1 && b < each->size(); ++b) {
    report.bodies.push_back({input.bodies[b].name, std::move((*each)[b]), std::move(walls[b])});
  }
  return report;
}

std::string measuresCsv(const MeasureReport& report) {
  const bool several = !report.bodies.empty();
  std::string csv = fmt::format(
      "time,{}volume,area,cx,cy,cz,components,genus,cavities,min_x,min_y,min_z,max_x,max_y,max_z,"
      "{}{}length_unit,time_unit\n",
      several ? "body," : "",
      !report.walls.empty() && report.walls.front().thickness ? "wall_thickness," : "",
      !report.walls.empty() && report.walls.front().normalSpeed ? "normal_speed," : "");
  const std::string units =
      fmt::format(",{},{}", csvField(report.lengthUnit), csvField(report.timeUnit));
  for (std::size_t i = 0; i < report.samples.size(); ++i) {
    if (!several) csv += rowOf(report.samples[i], report.walls[i], "", units);
    for (const BodyMeasures& body : report.bodies) {
      csv += rowOf(body.samples[i], body.walls[i], "," + csvField(body.name), units);
    }
  }
  return csv;
}

void describe(Members& members, const MeasureReport& report) {
  members("length_unit", report.lengthUnit, "Unit of all lengths: mm, m, ...; empty if unknown.")
      .joined(Joined::First);
  members("time_unit", report.timeUnit, "Unit of the times: s, ms, ...; empty if unknown.")
      .joined(Joined::First);
  members(
      "samples", samplesOf(report),
      "The solid at each time, in the order given: all bodies added up.",
      [](Members& own, const Sample& sample) {
        own("time", sample.solid.time, "In time units.");
        addSolidMeasures(own, sample.solid, sample.walls);
        own("bodies", sample.bodies,
            "Each of several bodies, without --total; nothing of one that does not exist at the "
            "time.",
            [](Members& ofBody, const Sample& body) {
              ofBody("name", body.name, "The name of the body.");
              addSolidMeasures(ofBody, body.solid, body.walls);
            })
            .itemsFrom(2)
            .onlyIf(!sample.bodies.empty());
      })
      .itemsFrom(1)
      .joined(Joined::Appended);
}

namespace {

using measure::SolidMeasures;
using nlohmann::ordered_json;

constexpr std::uint64_t kMostSamples = 10'000'000;

struct MeasureArguments {
  std::string input;
  FrameOptions frames;
  PartOption part;
  InputOptions only;
  std::vector<std::string> outputs;
  std::string html;
  bool total = false;
  bool thickness = false;
  bool normalSpeed = false;
  bool json = false;
};

/// A curve over time, in the order of time.
Plot plotOf(std::span<const SolidMeasures> samples, const std::string& title,
            const std::string& timeUnit, double (*value)(const SolidMeasures&)) {
  std::vector<const SolidMeasures*> inOrder;
  for (const SolidMeasures& sample : samples) inOrder.push_back(&sample);
  std::ranges::stable_sort(inOrder, {}, &SolidMeasures::time);
  Plot plot{title, labelled("time", timeUnit), {}, {}, {0.0}};
  plot.curves.push_back({title, "a", {}});
  for (const SolidMeasures* sample : inOrder) {
    plot.x.push_back(sample->time);
    plot.curves[0].values.push_back(value(*sample));
  }
  return plot;
}

Plot volumePlot(std::span<const SolidMeasures> samples, const formats::Metadata& metadata) {
  return plotOf(samples, labelled("Volume", metadata.lengthUnit, "³"), metadata.timeUnit,
                [](const SolidMeasures& sample) { return sample.volume; });
}

std::string pageOf(std::span<const SolidMeasures> samples, const formats::Metadata& metadata,
                   const std::string& title) {
  const std::string& time = metadata.timeUnit;
  return htmlPage(title, plotsOf({volumePlot(samples, metadata),
                                  plotOf(samples, labelled("Area", metadata.lengthUnit, "²"), time,
                                         [](const SolidMeasures& sample) { return sample.area; }),
                                  plotOf(samples, "Components", time,
                                         [](const SolidMeasures& sample) {
                                           return static_cast<double>(sample.components);
                                         }),
                                  plotOf(samples, "Genus", time, [](const SolidMeasures& sample) {
                                    return sample.genus;
                                  })}));
}

/// A table or a plot, as the extension says.
Result<std::string> fileOf(const std::string& path, const MeasureReport& measured,
                           const formats::Metadata& metadata) {
  const std::string extension = formats::lowerCaseExtension(path);
  if (extension == ".csv") return measuresCsv(measured);
  if (extension == ".json") return reportText(measured) + "\n";
  return plotFile(path, svgOf(volumePlot(measured.samples, metadata)));
}

std::vector<std::string> sampleFields(const SolidMeasures& sample, const WallMeasures& walls) {
  const model::Point3& centroid = sample.centroid;
  std::vector<std::string> fields = {
      fmt::format("{:.9g}", sample.volume), fmt::format("{:.9g}", sample.area),
      sample.bounds.empty()
          ? ""
          : fmt::format("({:.6g}, {:.6g}, {:.6g})", centroid.x(), centroid.y(), centroid.z()),
      grouped(sample.components), fmt::format("{:g}", sample.genus)};
  for (const auto& value : {walls.thickness, walls.normalSpeed}) {
    if (value) fields.push_back(fmt::format("{:.6g}", *value));
  }
  return fields;
}

void printSamples(const MeasureReport& measured) {
  const bool several = !measured.bodies.empty();
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](std::string time, const std::string& body,
                       const std::vector<std::string>& fields) {
    auto& row = rows.emplace_back(std::vector{std::move(time)});
    if (several) row.push_back(body);
    row.insert(row.end(), fields.begin(), fields.end());
  };
  std::vector<std::string> heading = {"volume", "area", "centroid", "components", "genus"};
  if (measured.walls.front().thickness) heading.emplace_back("wall thickness");
  if (measured.walls.front().normalSpeed) heading.emplace_back("normal speed");
  add("time", "body", heading);
  for (std::size_t i = 0; i < measured.samples.size(); ++i) {
    const std::string time = fmt::format("{:.6g}", measured.samples[i].time);
    if (!several) add(time, "", sampleFields(measured.samples[i], measured.walls[i]));
    for (const BodyMeasures& body : measured.bodies) {
      add(time, shownLine(body.name), sampleFields(body.samples[i], body.walls[i]));
    }
  }
  printTable(rows, several ? "rlrrlr" : "rrrlr");
}

int run(const MeasureArguments& options) {
  std::vector<std::string> outputs = options.outputs;
  if (!options.html.empty()) outputs.push_back(options.html);
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  const auto times = options.frames.atFrames
                         ? Result<std::vector<double>>(frameTimesOf(*input))
                         : options.frames.of(model::timeSpanOf(input->bodies), kMostSamples);
  if (!times) return report(times.error());
  if (auto good = checkOutputs(outputs); !good) return report(good.error());
  if (const auto done = options.part.settle(times->size(), "times")) return *done;
  ConsoleObserver observer;
  const auto measured = measure(
      *input,
      {*times, options.part.chosen(), !options.total, options.thickness, options.normalSpeed},
      observer);
  if (!measured) return report(measured.error());
  const std::vector<SolidMeasures>& samples = measured->samples;
  const formats::Metadata& metadata = input->metadata;
  for (const std::string& output : options.outputs) {
    const auto written = fileOf(output, *measured, metadata).and_then([&](const std::string& text) {
      return formats::writeOutputFile(output, text);
    });
    if (!written) return report(written.error());
  }
  if (!options.html.empty()) {
    const std::string title = std::filesystem::path(options.input).filename().string();
    if (auto written = formats::writeOutputFile(options.html, pageOf(samples, metadata, title));
        !written) {
      return report(written.error());
    }
  }
  if (options.json) {
    const auto identity = [&] { return identityOf(*input, times->size()); };
    tools::printText(options.part.inReport(Members::valueOf(*measured), identity) + "\n");
  } else if (outputs.empty()) {
    printSamples(*measured);
  } else {
    const auto [least, most] = std::ranges::minmax_element(samples, {}, &SolidMeasures::volume);
    for (const std::string& output : outputs) {
      print("{}: {}\n", output, counted(samples.size(), "time"));
    }
    print("  volume from {:.9g} at time {:.6g} to {:.9g} at time {:.6g}\n", least->volume,
          least->time, most->volume, most->time);
  }
  return kDone;
}

}  // namespace

void addMeasure(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "measure", "Measure a moving solid over time: volume, area, centroid, components, genus");
  auto options = std::make_shared<MeasureArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->frames.addTo(*command, kMostSamples);
  options->frames.addAtFramesTo(*command);
  options->part.addTo(*command,
                      "Measure only part K of N of the times; `t4d join` joins the reports");
  options->only.addTo(*command);
  command
      ->add_option(
          "-o,--output", options->outputs,
          "Output file: a table (.csv, .json) or a plot of the volume (.svg, .png); repeatable")
      ->allow_extra_args(false)
      ->check(someName())
      ->check(outputByExtension({kTablesAndPlots.begin(), kTablesAndPlots.end()}))
      ->type_name("FILE");
  command->add_option("--html", options->html, "Write a page with plots over time")
      ->check(htmlFile());
  command->add_flag("--total", options->total,
                    "Of several bodies: add them up, instead of a row for each");
  command->add_flag("--thickness", options->thickness, "Measure the mean thickness of walls, too");
  command->add_flag("--normal-speed", options->normalSpeed,
                    "Measure the mean speed of the surface along its normal, too");
  addJsonOption<MeasureReport>(*command, options->json, "A moving solid at many times.");
  command->footer(
      "Voxels of a mask that share a face, an edge or a corner are of one component.\n"
      "Example:\n  t4d measure heart.t4d --frames 200 -o volumes.csv -o volumes.png");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
