#include <algorithm>
#include <filesystem>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/output_file.h"
#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/table_output.h"
#include "tools/verbs/frame_times.h"
#include "tools/verbs/measure.h"

namespace t4d::tools {
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
Result<std::string> fileOf(const std::string& path, const verbs::MeasureReport& measured,
                           const formats::Metadata& metadata) {
  const std::string extension = formats::lowerCaseExtension(path);
  if (extension == ".csv") return measuresCsv(measured);
  if (extension == ".json") return verbs::reportText(measured) + "\n";
  return plotFile(path, svgOf(volumePlot(measured.samples, metadata)));
}

std::vector<std::string> sampleFields(const SolidMeasures& sample,
                                      const verbs::WallMeasures& walls) {
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

void printSamples(const verbs::MeasureReport& measured) {
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
    for (const verbs::BodyMeasures& body : measured.bodies) {
      add(time, shownLine(body.name), sampleFields(body.samples[i], body.walls[i]));
    }
  }
  printTable(rows, several ? "rlrrlr" : "rrrlr");
}

int run(const MeasureArguments& options) {
  std::vector<std::string> outputs = options.outputs;
  if (!options.html.empty()) outputs.push_back(options.html);
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  const auto times = options.frames.atFrames
                         ? Result<std::vector<double>>(verbs::frameTimesOf(*input))
                         : options.frames.of(model::timeSpanOf(input->bodies), kMostSamples);
  if (!times) return report(times.error());
  if (auto good = checkOutputs(outputs); !good) return report(good.error());
  if (const auto done = options.part.settle(times->size(), "times")) return *done;
  ConsoleObserver observer;
  const auto measured = verbs::measure(
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
    tools::printText(options.part.inReport(verbs::Members::valueOf(*measured), identity) + "\n");
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
  addJsonOption<verbs::MeasureReport>(*command, options->json, "A moving solid at many times.");
  command->footer(
      "Voxels of a mask that share a face, an edge or a corner are of one component.\n"
      "Example:\n  t4d measure heart.t4d --frames 200 -o volumes.csv -o volumes.png");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
