#ifndef SPROUT_SERVICES_GROW_CONFIDENCE_CONFIDENCE_MODEL_TEXT_H_
#define SPROUT_SERVICES_GROW_CONFIDENCE_CONFIDENCE_MODEL_TEXT_H_

namespace sprout::grow {

/// The content of confidence_model.textproto, which the build puts into the library.
extern const char* const kConfidenceModelText;

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_GROW_CONFIDENCE_CONFIDENCE_MODEL_TEXT_H_
