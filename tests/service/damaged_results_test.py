"""What is said of results that somebody damaged or took away: the truth, and what can be done."""

import unittest

from photond_daemon import DaemonTestCase, small_job


class DamagedResultsTest(DaemonTestCase):
    READS_FILM = ("image.exr", "preview.png", "pixels", "film")

    def job_and_film(self, **settings):
        job = self.daemon.run_job(small_job(**settings))["id"]
        [film] = (self.daemon.data_dir / "films").glob(f"{job}-*.film")
        return job, film

    def assert_damaged(self, reply, words, code="result_damaged"):
        self.assertEqual((reply.status, reply.json["code"]), (500, code), reply)
        self.assertIn("submit its request again", reply.json["title"])
        self.assertIn(words, reply.json["detail"])

    def test_a_film_taken_away(self):
        job, film = self.job_and_film(seed=11, passes=2)
        film.unlink()
        for name in self.READS_FILM:
            with self.subTest(name):
                self.assert_damaged(self.daemon.request("GET", f"/v1/jobs/{job}/{name}"),
                                    f"job {job} has lost {film.name}: it is not in the data folder's films/ any more",
                                    "result_lost")
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{job}/statistics.json").status, 200)
        other, _ = self.job_and_film(seed=11, passes=2, first_pass=2)
        self.assert_damaged(self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": [job, other]}), "has lost",
                            "result_lost")

    def test_a_damaged_film(self):
        job, film = self.job_and_film(seed=12)
        film.write_bytes(film.read_bytes()[:-1000])
        for name in self.READS_FILM[:-1]:  # the film itself is given as it is
            with self.subTest(name):
                self.assert_damaged(self.daemon.request("GET", f"/v1/jobs/{job}/{name}"),
                                    f"-{film.name} is damaged: it is cut short")

    def test_a_job_measured_against_a_film_taken_away(self):
        job, film = self.job_and_film(seed=13)
        film.unlink()
        measured = self.daemon.wait_for_job(self.daemon.submit(small_job(seed=14, reference=f"job:{job}"))["id"])
        self.assertEqual((measured["state"], measured["failure"]["code"]), ("failed", "result_lost"))
        self.assertEqual(self.daemon.run_job(small_job(seed=15))["state"], "succeeded")


if __name__ == "__main__":
    unittest.main()
