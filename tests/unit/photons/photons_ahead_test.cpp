// Photons of passes to come: those that the tracer gives, in whatever order passes are asked for, and given up at once.

#include "renderer/photons/photons_ahead.h"

#include <gtest/gtest.h>

#include <cstring>

#include "renderer/scene/builtin_scenes.h"
#include "tests/support/photons.h"

namespace photond::photons_ahead_test {
namespace {

using test::photon_tracing;
using test::PhotonScene;

constexpr uint64_t kSeed = 5;

class PhotonsAheadOfABox : public testing::Test {
protected:
    PhotonsAheadOfABox() { ahead.add(box.scene, *box.intersector, box.emission, tracing); }

    bool has_pass(uint32_t pass) const {
        const std::vector<Photon>& got = ahead.photons(PhotonMapKind::Global).photons;
        const std::vector<Photon> wanted = box.trace(tracing, kSeed, pass).photons;
        return got.size() == wanted.size() && std::memcmp(got.data(), wanted.data(), got.size() * sizeof(Photon)) == 0;
    }

    const PhotonScene box{make_builtin_scene("cornell-box")};
    PhotonTracing tracing = photon_tracing(PhotonMapKind::Global, 3000);
    PhotonsAhead ahead{kSeed};
    const CancelToken never;
};

TEST_F(PhotonsAheadOfABox, AreThoseOfThePassThatIsAskedFor) {
    for (const uint32_t pass : {0u, 1u, 2u, 7u, 3u, 3u}) {
        ASSERT_TRUE(ahead.wait(pass, never));
        EXPECT_TRUE(has_pass(pass)) << pass;
        ahead.begin(pass + 1);
        EXPECT_TRUE(has_pass(pass)) << "while those of the next one are on their way";
    }
}

TEST_F(PhotonsAheadOfABox, ArriveByThemselves) {
    ahead.begin(4);
    while (!ahead.arrived(4)) std::this_thread::yield();
    EXPECT_TRUE(has_pass(4));
    EXPECT_TRUE(ahead.arrived(4));
    EXPECT_FALSE(ahead.arrived(5)) << "nobody began it";
}

TEST_F(PhotonsAheadOfABox, AreGivenUpAndBegunAnew) {
    ahead.begin(0);
    ahead.stop();
    EXPECT_FALSE(ahead.arrived(0));
    ASSERT_TRUE(ahead.wait(0, never));
    EXPECT_TRUE(has_pass(0));
}

// Far more photons than this test could wait for.
TEST(PhotonsAhead, ThatNobodyWantsAnyMoreEndSoon) {
    const PhotonScene box(make_builtin_scene("cornell-box"));
    PhotonsAhead ahead(kSeed);
    ahead.add(box.scene, *box.intersector, box.emission, photon_tracing(PhotonMapKind::Global, 2'000'000'000));
    CancelToken cancel;
    cancel.cancel();
    EXPECT_FALSE(ahead.wait(0, cancel));
    ahead.begin(0);
    EXPECT_FALSE(ahead.wait(0, cancel));
}

}  // namespace
}  // namespace photond::photons_ahead_test
