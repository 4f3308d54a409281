// audit(), one question at a time.
#pragma once

#include <algorithm>
#include <utility>

#include "lamella/audit.hpp"

namespace audits {

inline lamella::Result<lamella::Audit> asked(bool lamella::AuditOptions::*question, const lamella::SliceResult& result,
                                             const lamella::Source& mesh, const lamella::Context& context = {}) {
    lamella::AuditOptions questions{.open = false, .volume = false, .ledger = false, .crossings = false};
    questions.*question = true;
    return audit(result, mesh, questions, context);
}

template <class Answer>
lamella::Result<Answer> answer_of(lamella::Result<lamella::Audit> found, std::optional<Answer> lamella::Audit::*answer) {
    if (!found) {
        return found.error();
    }
    return std::move(((*found).*answer).value());
}

inline lamella::Status structure_of(const lamella::SliceResult& result, const lamella::Source& mesh = lamella::MeshView{},
                                    const lamella::Context& context = {}) {
    const auto found = asked(&lamella::AuditOptions::structure, result, mesh, context);
    return found ? found->structure.value() : lamella::Status(found.error());
}

inline lamella::Result<lamella::Ledger> ledger_of(const lamella::SliceResult& result, const lamella::Source& mesh,
                                                  const lamella::Context& context = {}) {
    return answer_of(asked(&lamella::AuditOptions::ledger, result, mesh, context), &lamella::Audit::ledger);
}

inline lamella::Result<lamella::VolumeCertificate> volume_of(const lamella::SliceResult& result, const lamella::Source& mesh,
                                                             const lamella::Context& context = {}) {
    return answer_of(asked(&lamella::AuditOptions::volume, result, mesh, context), &lamella::Audit::volume);
}

inline lamella::Result<lamella::Crossings> crossings_of(const lamella::SliceResult& result,
                                                        const lamella::Context& context = {}) {
    return answer_of(asked(&lamella::AuditOptions::crossings, result, lamella::MeshView{}, context),
                     &lamella::Audit::crossings);
}

inline lamella::Result<lamella::OpenLayers> open_layers_of(const lamella::SliceResult& result,
                                                           const lamella::Context& context = {}) {
    return answer_of(asked(&lamella::AuditOptions::open, result, lamella::MeshView{}, context), &lamella::Audit::open);
}

inline bool same(const lamella::Crossings& one, const lamella::Crossings& other) {
    return one.count == other.count && one.at_least == other.at_least &&
           std::equal(one.layers.begin(), one.layers.end(), other.layers.begin(), other.layers.end(),
                      [](const lamella::LayerCrossings& a, const lamella::LayerCrossings& b) {
                          return a.layer == b.layer && a.count == b.count && a.at_least == b.at_least &&
                                 a.first == b.first && a.contours == b.contours;
                      });
}

}  // namespace audits
