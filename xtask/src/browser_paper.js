// Words by which the parts of a printed page are found again on its sheets. They take no room.
'use strict';
(() => {
  const mark = (element, word, style) => {
    const sign = document.createElement('span');
    sign.textContent = ` ${word} `;
    sign.style.cssText = `position: absolute; left: 0; font-size: 4px; ${style}`;
    element.style.position = 'relative';
    element.append(sign);
  };
  for (const [sign, elements] of [['figure', 'figure'], ['card', '.card']]) {
    document.querySelectorAll(elements).forEach((element, k) => {
      mark(element, `${sign}${k}begins`, 'top: 0');
      mark(element, `${sign}${k}ends`, 'bottom: 0');
    });
  }
  document.querySelectorAll('h2').forEach((heading, k) => {
    mark(heading, `heading${k}begins`, 'top: 0');
    mark(heading.nextElementSibling, `heading${k}ends`, 'top: 0; left: 40%');
  });
})();
