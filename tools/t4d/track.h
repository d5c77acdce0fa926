#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "measure/body_contacts.h"
#include "t4d/check.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

/// The tracks of one body.
struct BodyTracks {
  std::string name;
  std::uint64_t firstId = 1;  ///< the id of its first track; ids go on from body to body
  measure::Tracks tracks;
};

struct TrackReport {
  std::vector<BodyTracks> bodies;
  std::vector<measure::BodyContact> contacts = {};  ///< if asked for (addContacts)
  std::string lengthUnit;                           ///< "" if unknown
  std::string timeUnit;
  std::uint64_t prunedTracks = 0;  ///< of all bodies
  std::uint64_t prunedEvents = 0;
};

/// Tracks the components of each body (measure::tracksOf).
Result<TrackReport> track(const Input& input, const measure::TrackOptions& options = {},
                          Observer& observer = nobody());

/// Adds the contacts between bodies (measure::contactsOf), at the times of samples; or those in
/// part of the spans.
Result<void> addContacts(const Input& input, const measure::TrackOptions& options,
                         TrackReport& report, Observer& observer = nobody(),
                         const model::Part& part = {});

/// The name of a kind of event: appears, vanishes, splits, merges, rearranges, hole-opens,
/// hole-closes, cavity-appears, cavity-vanishes, cavity-opens, cavity-closes, cavities-split or
/// cavities-merge.
std::string_view nameOf(measure::TrackEventKind kind);

/// The ids of tracks of a body, with blanks between them.
std::string idText(const BodyTracks& body, const std::vector<std::uint32_t>& tracks);

/// The begin or the end of a track in one word: mesh, the name of an event of tracks, or, in a part
/// of a mesh, part.
std::string_view beginOf(const measure::Tracks& tracks, const measure::Track& track);
std::string_view endOf(const measure::Tracks& tracks, const measure::Track& track);

/// A row for each track:
/// track,body,kind,begin,end,begins,ends,from,into,largest_volume,length_unit, time_unit. Ids of
/// several tracks have blanks between them.
std::string tracksCsv(const TrackReport& report);
/// A row for each event: time,event,body,x,y,z,before,after,count,euler,length_unit,time_unit.
std::string eventsCsv(const TrackReport& report);
/// A row for each track at each time: track,body,time,volume,area,cx,cy,cz,speed,genus,cavities,
/// min_x,min_y,min_z,max_x,max_y,max_z,length_unit,time_unit.
std::string samplesCsv(const TrackReport& report);

/// A row for each contact at each time, or one without time and area:
/// contact,body,other,begin,end,largest_area,time,area,length_unit,time_unit. Contacts are numbered
/// from 1.
std::string contactsCsv(const TrackReport& report);

/// A directed graph with a node for each track and an edge from each to those that it goes into.
std::string graphMl(const TrackReport& report);
std::string dotGraph(const TrackReport& report);

void describe(Members& members, const TrackReport& report);

}  // namespace t4d::tools
