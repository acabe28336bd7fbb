"use strict";
(() => {
  const claims = [...document.querySelectorAll(".claim")];
  const chapters = [...document.querySelectorAll(".chapter")];
  const buttons = [...document.querySelectorAll("[data-show]")];

  const show = (wanted) => {
    for (const claim of claims) claim.hidden = wanted !== "all" && claim.dataset.outcome !== wanted;
    for (const chapter of chapters) chapter.hidden = !chapter.querySelector(".claim:not([hidden])");
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.show === wanted));
  };
  for (const button of buttons) button.addEventListener("click", () => show(button.dataset.show));

  // A link to a claim that the filter hides shows all claims again.
  const reveal = () => {
    const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target || !target.closest("[hidden]")) return;
    show("all");
    target.scrollIntoView();
  };
  addEventListener("hashchange", reveal);
  reveal();

  // All digits of a number, where nothing can point at it.
  document.addEventListener("click", (event) => {
    const number = event.target.closest("data[title]");
    if (!number) return;
    const shown = number.innerHTML;
    number.innerHTML = number.dataset.other ?? number.title;
    number.dataset.other = shown;
  });

  // The contents: folded on narrow screens, and where one is is marked.
  const folded = document.querySelector("nav details");
  const narrow = matchMedia("(max-width: 1000px)");
  const fold = () => { folded.open = !narrow.matches; };
  narrow.addEventListener("change", fold);
  fold();
  const links = new Map([...document.querySelectorAll("nav a")].map((link) => [link.hash.slice(1), link]));
  const places = [...links.keys()].map((key) => document.getElementById(key)).filter(Boolean);
  folded.addEventListener("click", (event) => { if (event.target.closest("a") && narrow.matches) folded.open = false; });
  const mark = () => {
    const seen = places.filter((place) => place.offsetParent && place.getBoundingClientRect().top < innerHeight / 3);
    const here = seen.at(-1) ?? places[0];
    for (const [key, link] of links) {
      if (here && key === here.id) link.setAttribute("aria-current", "location");
      else link.removeAttribute("aria-current");
    }
  };
  let waiting = false;
  addEventListener("scroll", () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; mark(); });
  }, { passive: true });
  mark();

  // On paper everything is open.
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...document.querySelectorAll("details:not([open])")];
    for (const each of closed) each.open = true;
  });
  addEventListener("afterprint", () => { for (const each of closed) each.open = false; });
})();
