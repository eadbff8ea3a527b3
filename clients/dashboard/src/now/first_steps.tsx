// What to begin with: large for who has rendered nothing yet, a line for everybody else. The pictures come with the page
// (start_pictures renders them): converged, and there before the daemon has drawn anything.

import boxPicture from "./pictures/cornell-box.jpg";
import glassPicture from "./pictures/cornell-box-glass.jpg";

const kSteps = [
  {
    href: "/studies/new?scene=cornell-box&preset=paths-photons",
    picture: boxPicture,
    title: "Compare two methods",
    text: "Render the Cornell box by two methods in the same time, and see which of them is closer to the truth.",
    brief: "Compare two methods",
  },
  {
    href: "/render?scene=cornell-box-glass",
    picture: glassPicture,
    title: "Render an image",
    text: "Choose a scene, a method and how long it may take, and watch the picture become.",
    brief: "Render an image",
  },
  {
    href: "/scenes",
    picture: null,
    title: "Bring your own scene",
    text: "Upload a glTF file, orbit about it until you like the view, and render it from there.",
    brief: "Bring a scene",
  },
];

/** A file on its way into a frame. */
const Dropping = () => (
  <svg class="now-dropping" viewBox="0 0 160 120" aria-hidden="true" fill="none" stroke="currentColor" stroke-width="2.5" stroke-linejoin="round">
    <rect x="14" y="12" width="132" height="96" rx="6" stroke-dasharray="7 6" opacity="0.5" />
    <path d="M62 30h26l14 14v46H62z" />
    <path d="M88 30v14h14" />
    <path d="M82 52v24m-9-9 9 9 9-9" stroke-linecap="round" />
  </svg>
);

export function FirstSteps() {
  return (
    <section class="now-first" aria-labelledby="now-first">
      <p class="now-what">
        photond renders scenes by many methods of global illumination, and measures which of them gets nearest to the truth, soonest.
      </p>
      <h2 id="now-first">Where to begin</h2>
      <ul class="now-steps">
        {kSteps.map((step) => (
          <li key={step.href}>
            <a class="panel now-step" href={step.href}>
              {step.picture ? <img class="now-picture" src={step.picture} alt="" width={480} height={360} /> : <Dropping />}
              <strong>{step.title}</strong>
              <span>{step.text}</span>
            </a>
          </li>
        ))}
      </ul>
    </section>
  );
}

export function NextSteps() {
  return (
    <nav class="now-next" aria-label="What to do">
      {kSteps.map((step) => (
        <a key={step.href} href={step.href}>
          {step.brief}
        </a>
      ))}
    </nav>
  );
}
