// What to begin with: large for who has rendered nothing yet, a line for everybody else.

import { Picture } from "../ui/picture";

const kSteps = [
  {
    href: "/studies/new?scene=cornell-box",
    picture: "cornell-box",
    title: "Compare two methods",
    text: "Render the Cornell box by two methods in the same time, and see which of them is closer to the truth.",
    brief: "Compare two methods",
  },
  {
    href: "/render?scene=cornell-box-glass",
    picture: "cornell-box-glass",
    title: "Render an image",
    text: "Choose a scene, a method and how long it may take, and watch the picture become.",
    brief: "Render an image",
  },
  {
    href: "/scenes",
    picture: "interior",
    title: "Bring your own scene",
    text: "Drop a glTF file, orbit about it until you like the view, and render it from there.",
    brief: "Bring a scene",
  },
];

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
              <Picture path={`/v1/scenes/${step.picture}/thumbnail.png`} alt="" ratio={4 / 3} />
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
