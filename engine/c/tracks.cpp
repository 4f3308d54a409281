// The calls of tracks.h.
#include <memory>
#include <utility>

#include "c/call.hpp"

namespace api = lamella::c;

int32_t lamella_find_tracks(const lamella_result* result, const lamella_track_options* options,
                            const lamella_context* context, lamella_tracks** tracks, lamella_error* error) {
    return api::called(error, [&] {
        api::require_place(tracks, "the tracks", "tracks");
        api::require_given(result, "the result");
        const api::Host host(context);
        const lamella::TrackOptions how{.pockets = api::read_sized(options).pockets != 0};
        lamella::Tracks found = lamella::require(lamella::find_tracks(result->result, how, host.context));
        auto fresh = std::make_unique<lamella_tracks>(lamella_tracks{std::move(found)});
        lamella_tracks_free(std::exchange(*tracks, fresh.release()));
    });
}

void lamella_tracks_view(const lamella_tracks* tracks, lamella_track_arrays* arrays) {
    lamella_track_arrays c{};
    if (tracks != nullptr) {
        const lamella::Tracks& found = tracks->tracks;
        c.islands = api::as_c<lamella_track>(found.islands.data());
        c.island_count = found.islands.size();
        c.links = api::as_c<lamella_track_link>(found.links.data());
        c.links_by_upper = found.links_by_upper.data();
        c.link_count = found.links.size();
        c.pockets = api::as_c<lamella_pocket>(found.pockets.data());
        c.pocket_count = found.pockets.size();
        c.bodies = found.bodies;
    }
    api::write_sized(c, arrays);
}

void lamella_tracks_free(lamella_tracks* tracks) {
    delete tracks;
}
