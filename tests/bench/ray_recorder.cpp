#include "tests/bench/ray_recorder.h"

#include <limits>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace {

// The wrappers are C functions without a place for state.
std::vector<qray::bench::RecordedRay>* recording = nullptr;
RTCScene recorded_scene = nullptr;

void record(RTCScene scene, const RTCRay& r, float t_max) {
  recorded_scene = scene;
  recording->push_back({{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, t_max});
}

void record(RTCScene scene, const int* valid, const RTCRay8& r) {
  for (int i = 0; i < 8; ++i) {
    if (!valid[i]) continue;
    recorded_scene = scene;
    recording->push_back(
        {{r.org_x[i], r.org_y[i], r.org_z[i]}, {r.dir_x[i], r.dir_y[i], r.dir_z[i]}, -1});
  }
}

RTCRay to_rtc(const qray::bench::RecordedRay& ray) {
  RTCRay r;
  r.org_x = ray.o.x;
  r.org_y = ray.o.y;
  r.org_z = ray.o.z;
  r.tnear = 0;
  r.dir_x = ray.d.x;
  r.dir_y = ray.d.y;
  r.dir_z = ray.d.z;
  r.time = 0;
  r.tfar = ray.t_max < 0 ? std::numeric_limits<float>::infinity() : ray.t_max;
  r.mask = ~0u;
  r.id = 0;
  r.flags = 0;
  return r;
}

}  // namespace

extern "C" {
#if RTC_VERSION_MAJOR >= 4
void __real_rtcIntersect1(RTCScene, RTCRayHit*, RTCIntersectArguments*);
void __real_rtcOccluded1(RTCScene, RTCRay*, RTCOccludedArguments*);
void __wrap_rtcIntersect1(RTCScene scene, RTCRayHit* query, RTCIntersectArguments* arguments) {
  if (recording) record(scene, query->ray, -1);
  __real_rtcIntersect1(scene, query, arguments);
}
void __real_rtcIntersect8(const int*, RTCScene, RTCRayHit8*, RTCIntersectArguments*);
void __wrap_rtcIntersect8(const int* valid, RTCScene scene, RTCRayHit8* query,
                          RTCIntersectArguments* arguments) {
  if (recording) record(scene, valid, query->ray);
  __real_rtcIntersect8(valid, scene, query, arguments);
}
void __wrap_rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments) {
  if (recording) record(scene, *ray, ray->tfar);
  __real_rtcOccluded1(scene, ray, arguments);
}
#else
void __real_rtcIntersect1(RTCScene, RTCIntersectContext*, RTCRayHit*);
void __real_rtcOccluded1(RTCScene, RTCIntersectContext*, RTCRay*);
void __real_rtcOccluded1M(RTCScene, RTCIntersectContext*, RTCRay*, unsigned, size_t);
void __wrap_rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* query) {
  if (recording) record(scene, query->ray, -1);
  __real_rtcIntersect1(scene, context, query);
}
void __real_rtcIntersect8(const int*, RTCScene, RTCIntersectContext*, RTCRayHit8*);
void __wrap_rtcIntersect8(const int* valid, RTCScene scene, RTCIntersectContext* context,
                          RTCRayHit8* query) {
  if (recording) record(scene, valid, query->ray);
  __real_rtcIntersect8(valid, scene, context, query);
}
void __wrap_rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  if (recording) record(scene, *ray, ray->tfar);
  __real_rtcOccluded1(scene, context, ray);
}
void __wrap_rtcOccluded1M(RTCScene scene, RTCIntersectContext* context, RTCRay* rays,
                          unsigned count, size_t stride) {
  if (recording)
    for (unsigned i = 0; i < count; ++i) record(scene, rays[i], rays[i].tfar);
  __real_rtcOccluded1M(scene, context, rays, count, stride);
}
#endif
}

namespace qray::bench {

RayRecorder::RayRecorder(std::vector<RecordedRay>& rays) { recording = &rays; }
RayRecorder::~RayRecorder() { recording = nullptr; }

size_t replay(const std::vector<RecordedRay>& rays, size_t begin, size_t end) {
  size_t hits = 0;
#if RTC_VERSION_MAJOR < 4
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
#endif
  for (size_t i = begin; i < end; ++i) {
    if (rays[i].t_max < 0) {
      RTCRayHit query;
      query.ray = to_rtc(rays[i]);
      query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
      __real_rtcIntersect1(recorded_scene, &query, nullptr);
#else
      __real_rtcIntersect1(recorded_scene, &context, &query);
#endif
      hits += query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    } else {
      RTCRay query = to_rtc(rays[i]);
#if RTC_VERSION_MAJOR >= 4
      __real_rtcOccluded1(recorded_scene, &query, nullptr);
#else
      __real_rtcOccluded1(recorded_scene, &context, &query);
#endif
      hits += query.tfar < 0;
    }
  }
  return hits;
}

}  // namespace qray::bench
